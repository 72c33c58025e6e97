//! What selective regularisation must know of a subpath: whether the path can be sampled at all, and where else it could have
//! been connected.
//!
//! A path is sampled without bias if two neighbours can both be connected, DD in Heckbert's notation with the light's point and
//! the lens counted as D, because next event estimation and light images connect them (Veach 1997, theorem 8.2; Kaplanyan 2017,
//! section 6.1.2), if a ray can hit its light or its lens, or if photons are merged at one of its vertices that is not specular.
//! Otherwise its D and S alternate or its S follow each other, and an edge that joins a D with an S is connected with the S
//! blurred. There always is one, at the light, so that no path needs two blurred vertices; of several the longest is taken,
//! where the blur's angle is smallest (section 6.2.5), and of equal ones that nearest to the light.
//!
//! A [`SpecularChain`] is the state of a subpath up to the edge to its present vertex, which may itself be D in one connection
//! and S in another where its material is a mixture. Lengths are squared. Invariant (tests): of the edges of a path that can be
//! connected one and only one is chosen.

use bytemuck::{Pod, Zeroable};

/// Bits of [`SpecularChain::state`].
pub mod state {
    /// Something can sample the path without bias, whatever the rest of it.
    pub const SAMPLED: u32 = 1;
    /// The vertex before is not specular: it can be connected.
    pub const IS_ROUGH: u32 = 2;
    /// The vertex before is a specular one.
    pub const IS_SPECULAR: u32 = 4;
    /// Photons are merged at vertices that are not specular.
    pub const MERGES: u32 = 8;
}

/// A subpath before its present vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SpecularChain {
    /// Squared length of the longest edge between a rough and a specular vertex, without the last edge; zero without any.
    pub longest: f32,
    /// Squared length of the last edge.
    pub edge: f32,
    /// Bits of [`state`].
    pub state: u32,
}

impl SpecularChain {
    /// At the end of the subpath: its first edge ends at the present vertex, with the start in `state`.
    #[inline]
    pub fn start(state: u32, edge: f32) -> SpecularChain {
        SpecularChain {
            longest: 0.0,
            edge,
            state,
        }
    }

    /// With the last edge counted, which ends at a vertex that is specular or not.
    #[inline]
    pub fn ending(self, is_specular: bool) -> SpecularChain {
        let mut chain = self;
        let other = if is_specular {
            state::IS_ROUGH
        } else {
            state::IS_SPECULAR
        };
        if self.state & other != 0 && self.edge > self.longest {
            chain.longest = self.edge;
        }
        let is_sampled = !is_specular && self.state & (state::IS_ROUGH | state::MERGES) != 0;
        if is_sampled {
            chain.state |= state::SAMPLED;
        }
        chain
    }

    /// After scattering at the present vertex.
    #[inline]
    pub fn scattered(self, is_specular: bool) -> SpecularChain {
        let mut chain = self.ending(is_specular);
        chain.state &= !(state::IS_ROUGH | state::IS_SPECULAR);
        chain.state |= if is_specular {
            state::IS_SPECULAR
        } else {
            state::IS_ROUGH
        };
        chain
    }

    /// Whether nothing in this subpath samples the path.
    #[inline]
    pub fn is_unsampled(&self) -> bool {
        self.state & state::SAMPLED == 0
    }
}

/// Whether the edge of squared length `edge` that joins the two subpaths is the one whose specular end is blurred; both have
/// counted their last edges ([`SpecularChain::ending`]).
#[inline]
pub fn is_chosen(light: &SpecularChain, camera: &SpecularChain, edge: f32) -> bool {
    light.is_unsampled() && camera.is_unsampled() && edge > light.longest && edge >= camera.longest
}
