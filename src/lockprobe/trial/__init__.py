"""One trial: its plan, the closed loop, its record, and the interfaces of everything that meets in the loop."""
