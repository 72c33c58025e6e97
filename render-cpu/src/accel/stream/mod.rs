//! Many rays at a time, on processors with AVX-512.

mod bundle16;
mod lanes16;
mod lockstep;
mod node16;
mod root16;
mod sixteen;
mod spheres16;
mod triangles16;
