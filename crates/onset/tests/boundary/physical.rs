//! Boundaries of the laws and of their discretizations.
