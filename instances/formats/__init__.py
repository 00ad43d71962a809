"""Readers and writers of instance files."""
