"""Anybody's episodes, of any task, on the page that studies of lockboxes have: no new statistics."""
