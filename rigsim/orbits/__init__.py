"""Converged periodic motions: harmonic balance, continuation, stability, shooting, subharmonics."""
