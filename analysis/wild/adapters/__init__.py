"""Adapters: each turns a simulator into a candidate of ``longball judge``."""
