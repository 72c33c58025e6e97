//! A loop as long as it is told, to find devices that end loops early.

use crate::interface::Dispatch;
use spirv_std::spirv;

/// Counts to `dispatch.count` and says how far it came.
#[spirv(compute(threads(1)))]
pub fn canary(
    #[spirv(push_constant)] dispatch: &Dispatch,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] out: &mut [u32],
) {
    let mut counted = 0;
    let mut state = 1;
    while counted < dispatch.count {
        counted += 1;
        // Something that no compiler foresees.
        state = halflight_kernel::sampler::mix(state + counted);
        if state == dispatch.seed {
            break;
        }
    }
    out[0] = counted;
}
