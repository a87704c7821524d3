"""Tests under feedback: unstable motions held and measured, and motions followed at a phase."""
