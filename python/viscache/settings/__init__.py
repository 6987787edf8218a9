"""What a frame is asked to be: integrators, rays, visibility; how they are named and checked."""
