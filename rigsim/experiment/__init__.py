"""Tests of the multi-body rig, one file a protocol, and the records they give; file formats are read here."""
