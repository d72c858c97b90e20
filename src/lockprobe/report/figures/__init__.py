"""The paper's figures and others, drawn by Matplotlib from the rows of results and from nothing else."""
