"""What all packages stand on: errors, specs, plug-ins, seeds, files, processes, servers; nothing of lockboxes."""
