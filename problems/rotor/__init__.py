"""Lateral vibration of a rotor on bearings: description, finite elements, modes, and the synchronous response."""
