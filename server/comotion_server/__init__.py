"""Motion and collisions of rigid bodies."""
