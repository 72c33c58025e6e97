//! Checks that the processor supports the instruction set for which the program was compiled.
//!
//! `.cargo/config.toml` sets the third level of x86-64. On an older processor the program would end with a bare "illegal
//! instruction"; this check ends it with an explanation instead.

use crate::say::note;

/// Ends the program with exit code 1 and one line on standard error if the processor lacks instructions that it was
/// compiled with. To be called first of all.
pub fn exit_unless_sufficient() {
    if let Some(message) = insufficiency() {
        note(format_args!("error: {message}"));
        std::process::exit(1);
    }
}

/// The sentence about a processor that lacks instructions that the program was compiled with.
pub fn insufficiency() -> Option<String> {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    {
        use std::arch::x86_64::__cpuid_count;
        let missing = missing(__cpuid_count(1, 0).ecx, __cpuid_count(7, 0).ebx);
        if !missing.is_empty() {
            return Some(format!(
                "this program was compiled for processors with {}, which this one lacks; compile it with \
                 RUSTFLAGS=-Ctarget-cpu=x86-64 in the environment",
                missing.join(", ")
            ));
        }
    }
    None
}

/// What is missing for the third level of x86-64, of the features by which its processors differ from earlier ones, from
/// the register ecx of leaf 1 and ebx of leaf 7 (Intel's manual, volume 2, CPUID).
#[cfg(any(test, all(target_arch = "x86_64", target_feature = "avx2")))]
fn missing(leaf1_ecx: u32, leaf7_ebx: u32) -> Vec<&'static str> {
    let needed = [
        ("FMA", leaf1_ecx, 12),
        ("MOVBE", leaf1_ecx, 22),
        ("AVX enabled by the system", leaf1_ecx, 27),
        ("AVX", leaf1_ecx, 28),
        ("F16C", leaf1_ecx, 29),
        ("BMI1", leaf7_ebx, 3),
        ("AVX2", leaf7_ebx, 5),
        ("BMI2", leaf7_ebx, 8),
    ];
    needed
        .into_iter()
        .filter(|&(_, register, bit)| register & (1 << bit) == 0)
        .map(|(name, _, _)| name)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::missing;

    #[test]
    fn features_are_told_apart() {
        assert!(missing(u32::MAX, u32::MAX).is_empty());
        assert_eq!(missing(u32::MAX, !(1 << 5)), ["AVX2"]);
        assert_eq!(missing(!(1 << 12), !(1 << 3)), ["FMA", "BMI1"]);
        assert_eq!(missing(0, 0).len(), 8);
    }
}
