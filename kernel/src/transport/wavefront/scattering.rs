//! What the sampling of a queue's directions reads.

use super::lobes::LobeLanes;
use super::random_numbers::NumberLanes;
use super::segment::Segment;
use super::surfaces::PointLanes;

/// Surface points, lobes and random numbers of a queue.
#[derive(Clone, Copy)]
pub(super) struct ScatteringInputs<'a, const N: usize> {
    pub points: &'a PointLanes<N>,
    pub lobes: &'a LobeLanes<N>,
    pub numbers: &'a NumberLanes<N>,
    pub segment: Segment,
}
