"""Tests of the multi-body rig, one file a protocol, and the records they give in the formats of a room of their own."""
