//! Criterion benchmarks of the hot loops; see the README beside this file.
