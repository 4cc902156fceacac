"""Lateral vibration of a rotor on bearings.

Description, finite elements, modes, and the synchronous response.
"""
