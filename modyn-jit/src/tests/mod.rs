//! Tests that see more than the public interface.
