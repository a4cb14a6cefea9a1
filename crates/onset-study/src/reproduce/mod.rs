//! The paper from end to end.
