"""The bridge from pictures to flips: which part of the effect of pictures misreadings account for, as false reports."""
