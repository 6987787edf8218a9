"""Scenes, rays and pictures that figures and benches both measure."""
