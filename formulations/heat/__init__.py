"""Exact methods and bounds for order and start points under the temperature model of ``instances.heat``."""
