"""Scenes, rays and pictures for both figures and benches."""
