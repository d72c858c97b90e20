"""Plants: what agents act on, from symbolic rules over MuJoCo simulations to real robots."""
