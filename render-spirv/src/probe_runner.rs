//! Running entry points that are no renderer: function probes and readers' own shaders.

use crate::interface::WORKGROUP;
use crate::probe::ProbeDispatch;
use crate::vulkan::{Buffer, Device, Memory, Pipeline, VulkanError};
use bytemuck::{AnyBitPattern, NoUninit, Pod};
use std::ffi::CStr;
use std::marker::PhantomData;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time after which a dispatch counts as hung.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// A probe's entry point, compiled, with buffers for a number of inputs.
pub struct Probe<I, O> {
    // The pipeline first: it is dropped before the buffers that it binds.
    pipeline: Pipeline,
    inputs: Buffer,
    outputs: Buffer,
    _data: Buffer,
    /// What the driver took to compile it.
    pub compile_time: Duration,
    records: PhantomData<(I, O)>,
}

impl<I: NoUninit, O: Pod> Probe<I, O> {
    /// The entry point `entry` of `module` for up to `capacity` inputs, with the tables `data` that they refer to and
    /// the values `constants` of its specialisation constants.
    ///
    /// # Errors
    /// If the device has no room or its driver refuses the shader.
    pub fn new(
        device: &Arc<Device>,
        module: &[u32],
        entry: &CStr,
        capacity: usize,
        data: &[f32],
        constants: &[u32],
    ) -> Result<Probe<I, O>, VulkanError> {
        let inputs = device.create_buffer(
            "inputs of a probe",
            (capacity * size_of::<I>()) as u64,
            Memory::Host,
        )?;
        let outputs = device.create_buffer(
            "outputs of a probe",
            (capacity * size_of::<O>()) as u64,
            Memory::Host,
        )?;
        let data = device.upload("tables of a probe", data)?;
        let start = Instant::now();
        let pipeline = device.create_specialized_pipeline(
            module,
            entry,
            &[&inputs, &data, &outputs],
            size_of::<ProbeDispatch>() as u32,
            constants,
        )?;
        Ok(Probe {
            pipeline,
            inputs,
            outputs,
            _data: data,
            compile_time: start.elapsed(),
            records: PhantomData,
        })
    }

    /// What function `function` of the entry point returns for each input.
    ///
    /// # Errors
    /// If the device fails.
    ///
    /// # Panics
    /// With more inputs than the probe was made for.
    pub fn run(&mut self, function: u32, inputs: &[I]) -> Result<Vec<O>, VulkanError> {
        self.inputs.write(inputs);
        let dispatch = ProbeDispatch {
            count: inputs.len() as u32,
            function,
        };
        let groups = dispatch.count.div_ceil(WORKGROUP);
        self.pipeline
            .dispatch("a probe", &dispatch, groups, TIME_LIMIT)?;
        let mut outputs = vec![O::zeroed(); inputs.len()];
        self.outputs.read(&mut outputs);
        Ok(outputs)
    }
}

/// An entry point of a module.
#[derive(Clone, Copy)]
pub struct EntryPoint<'a> {
    /// The words of the module.
    pub module: &'a [u32],
    /// The name of the entry point.
    pub name: &'a CStr,
}

/// Runs `groups` workgroups of any entry point whose buffers are `tables` and, after them, one of `count` results, and
/// whose push constants are `constants`.
///
/// # Errors
/// If the device has no room or fails.
pub fn run_once<O: Pod + AnyBitPattern>(
    device: &Arc<Device>,
    entry: EntryPoint<'_>,
    tables: &[&[u8]],
    constants: &impl NoUninit,
    groups: u32,
    count: usize,
) -> Result<Vec<O>, VulkanError> {
    let mut buffers = Vec::new();
    for table in tables {
        buffers.push(device.upload("a table", table)?);
    }
    let mut results =
        device.create_buffer("results", (count * size_of::<O>()) as u64, Memory::Host)?;
    results.write(&vec![0u8; count * size_of::<O>()]);
    let mut bound: Vec<&Buffer> = buffers.iter().collect();
    bound.push(&results);
    let pipeline = device.create_pipeline(
        entry.module,
        entry.name,
        &bound,
        size_of_val(constants) as u32,
    )?;
    pipeline.dispatch("a shader", constants, groups, TIME_LIMIT)?;
    let mut out = vec![O::zeroed(); count];
    results.read(&mut out);
    Ok(out)
}
