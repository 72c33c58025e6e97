//! Light-transport algorithms, one per file.
