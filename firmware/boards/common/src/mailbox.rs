//! Two rings of frames in shared memory.
