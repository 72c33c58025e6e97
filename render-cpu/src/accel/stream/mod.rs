//! Ray streams: many rays at a time through the trees, sixteen in lanes, on processors with AVX-512.
//!
//! A single ray's walk waits: for a node, for the result of its test, for a guess about what comes next that was wrong. A
//! stream has other rays to go on with meanwhile. [`trace`] is the only entry point; it finds the hits of single rays
//! ([`super::single`]) to the bit, because which hit comes first does not depend on the order of a walk
//! ([`halflight_kernel::scene::Traverse::closest_hit`]).
//!
//! # The story
//! 1. [`root`] begins all rays of the stream: every one meets the same node first, the root, whose planes are constants then.
//!    What a ray brings to every later test (the inverse of its direction, its shear) is prepared once.
//! 2. Sixteen rays in a row that start and point alike, as those of a pixel's samples do, are a *packet* ([`packet`]): they
//!    go through the tree together, and whatever they test is the same for all of them.
//! 3. Other rays walk in *lockstep* ([`lockstep`]): each at its own node, sixteen at a step, without a branch on what they
//!    are. A ray that is done is replaced by the next one of the stream.
//! 4. Leaves wait in a queue ([`leaf_queue`]) until there are sixteen, whichever rays they are for, and are then tested at
//!    once ([`leaves`]): triangles and spheres in lanes, other primitives by the walk of single rays.
//! 5. Rays in lanes and their nearest hits are in [`rays`]; hits go back to where the ray was in the stream.
//!
//! The tests themselves are written once for all widths, in [`super::simd`]; what depends on sixteen lanes is how rows are
//! gathered into columns, compressed into the queue and expanded from the stream.
//!
//! # A node
//! Nodes are those of Ylitie, Karras and Laine 2017, eight children in 80 bytes: five rows of four words, so that sixteen
//! nodes become columns by loads of rows and shuffles, whichever nodes they are.
//!
//! ```text
//!          word 0          word 1          word 2          word 3
//!        +---------------+---------------+---------------+---------------+
//! row 0  | corner x      | corner y      | corner z      | ex ey ez inner|  step 2^e of the grid; bit k: child k is a node
//!        +---------------+---------------+---------------+---------------+
//! row 1  | first child   | first entry   | meta 0 1 2 3  | meta 4 5 6 7  |  what is behind each child
//!        +---------------+---------------+---------------+---------------+
//! row 2  | lower x planes, a byte a child| upper x planes                |  plane q at corner + q step
//! row 3  | lower y planes                | upper y planes                |
//! row 4  | lower z planes                | upper z planes                |
//!        +---------------+---------------+---------------+---------------+
//! ```
//!
//! The upper three bits of a child's meta, shifted by its lower five, are its bits in a word of 32: one for each of its leaf
//! entries in the lower 24, or one of the upper eight if it is a node. The OR over the children that a ray meets is all
//! that a step has to find out. Children that are nodes lie one behind the other from `first child` on, so that child k is
//! number popcount(inner & (2^k - 1)) of them; the entries of all leaves of a node follow from `first entry` on.
//!
//! # A leaf entry
//! An entry ([`super::build::leaf_entry`]) is one cache line: two triangles that share an edge, one alone, or another primitive.
//!
//! ```text
//!        +------+------+------+------------------------+
//! row 0  | a.x  | a.y  | a.z  | primitive of abc       |        d ------- c
//!        +------+------+------+------------------------+        |       / |
//! row 1  | b.x  | b.y  | b.z  | primitive of acd, none |        |    /    |
//!        +------+------+------+------------------------+        | /       |
//! row 2  | c.x  | c.y  | c.z  | rotations of both      |        a ------- b
//!        +------+------+------+------------------------+
//! row 3  | d.x  | d.y  | d.z  |                        |
//!        +------+------+------+------------------------+
//! ```

mod child_order;
mod leaf_queue;
mod leaves;
mod lockstep;
mod nodes;
mod packet;
mod rays;
mod root;

pub use lockstep::trace;
