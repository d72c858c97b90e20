"""Every sentence on results: the rooms below give numbers, and here they are put into words."""
