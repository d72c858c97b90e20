"""A study directory as numbers, tables, figures and one page that a scientist reads in a minute."""
