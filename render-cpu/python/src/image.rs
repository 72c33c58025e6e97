//! Images: layers as arrays of numpy, and what is known of their making.
//!
//! The arrays of the layers (`layers`) are made once, interleaved from the planes of the film, and belong to the image: what
//! Python writes into them is what [`PyImage::write`] writes.

use crate::error::{file_error, value_error};
use crate::layers::{Data, Layer, Plane, RADIANCE, layers};
use halflight::image::exr_output::{ChannelValues, LayeredImage, write_exr};
use halflight::image::metadata::ImageMetadata;
use halflight::image::{ExrImage, read_exr};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// An image with its layers.
#[pyclass(frozen, module = "halflight", name = "Image")]
pub(crate) struct PyImage {
    width: u32,
    height: u32,
    offset: [i32; 2],
    full_size: [u32; 2],
    layers: Vec<Layer>,
    metadata: ImageMetadata,
    interrupted: bool,
}

impl PyImage {
    /// The image of a film.
    pub(crate) fn from_film(
        py: Python<'_>,
        image: LayeredImage,
        interrupted: bool,
    ) -> PyResult<PyImage> {
        let planes = image.channels.into_iter().map(|(name, values)| {
            let plane = match values {
                ChannelValues::Float(v) | ChannelValues::Colour(v) => Plane::Float(v),
                ChannelValues::Count(v) => Plane::Count(v),
            };
            (name, plane)
        });
        let (width, height) = (image.width, image.height);
        Ok(PyImage {
            layers: layers(py, planes.collect(), width as usize, height as usize)?,
            width,
            height,
            offset: image.offset,
            full_size: image.full_size,
            metadata: image.metadata,
            interrupted,
        })
    }

    fn layer(&self, name: &str) -> PyResult<&Layer> {
        let found = self.layers.iter().find(|layer| layer.name == name);
        found.ok_or_else(|| {
            let names: Vec<_> = self.layers.iter().map(|l| l.name.as_str()).collect();
            PyKeyError::new_err(format!(
                "no layer \"{name}\"; the image has {}",
                names.join(", ")
            ))
        })
    }

    /// The image as planes.
    pub(crate) fn to_layered(&self, py: Python<'_>) -> PyResult<LayeredImage> {
        let mut channels = Vec::new();
        for layer in &self.layers {
            let depth = layer.channels.len();
            match &layer.data {
                Data::Float(array) => {
                    let array = array.bind(py).readonly();
                    let values = array.as_slice().map_err(value_error)?;
                    for (c, name) in layer.channels.iter().enumerate() {
                        let plane = values.iter().skip(c).step_by(depth).copied().collect();
                        // What film and reader hold as colours may be written with 16 bits; nobody asks for that here.
                        channels.push((name.clone(), ChannelValues::Float(plane)));
                    }
                }
                Data::Count(array) => {
                    let array = array.bind(py).readonly();
                    let values = array.as_slice().map_err(value_error)?;
                    channels.push((
                        layer.channels[0].clone(),
                        ChannelValues::Count(values.to_vec()),
                    ));
                }
            }
        }
        Ok(LayeredImage {
            width: self.width,
            height: self.height,
            offset: self.offset,
            full_size: self.full_size,
            channels,
            metadata: self.metadata.clone(),
        })
    }

    /// The image as if read from its file.
    pub(crate) fn to_exr(&self, py: Python<'_>) -> PyResult<ExrImage> {
        let image = self.to_layered(py)?;
        let planes = image.channels.into_iter().map(|(name, values)| {
            let values = match values {
                ChannelValues::Float(v) | ChannelValues::Colour(v) => v,
                ChannelValues::Count(v) => v.into_iter().map(|n| n as f32).collect(),
            };
            (name, values)
        });
        let attributes = image.metadata.attributes().into_iter();
        Ok(ExrImage {
            width: image.width,
            height: image.height,
            origin: image.offset,
            display_size: image.full_size,
            channels: planes.collect(),
            attributes: attributes.map(|(n, v)| (n.to_owned(), v)).collect(),
            warnings: Vec::new(),
        })
    }
}

#[pymethods]
impl PyImage {
    /// Width in pixels.
    #[getter]
    fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[getter]
    fn height(&self) -> u32 {
        self.height
    }

    /// Column and row of the first pixel in the whole image, of which this may be a crop.
    #[getter]
    fn offset(&self) -> (i32, i32) {
        (self.offset[0], self.offset[1])
    }

    /// Names of the layers.
    #[getter]
    fn layers(&self) -> Vec<String> {
        self.layers.iter().map(|layer| layer.name.clone()).collect()
    }

    /// Radiance in W/(m^2 sr), linear sRGB: float32 of the shape (height, width, 3). The image's own array, not a copy.
    #[getter]
    fn radiance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.__getitem__(py, RADIANCE)
    }

    /// Variance of the mean of each pixel and channel, (W/(m^2 sr))^2: float32 of the shape (height, width, 3).
    ///
    /// Raises KeyError for an image that was read from a file without that layer.
    #[getter]
    fn variance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.__getitem__(py, "variance")
    }

    /// Number of samples of each pixel: an array of the shape (height, width).
    ///
    /// Raises KeyError for an image that was read from a file without that layer.
    #[getter]
    fn samples(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.__getitem__(py, "samples")
    }

    /// Samples per pixel on average; zero where not known.
    #[getter]
    fn spp(&self) -> f64 {
        self.metadata.spp
    }

    /// Seconds spent rendering; zero where not known.
    #[getter]
    fn seconds(&self) -> f64 {
        self.metadata.render_seconds
    }

    /// Whether the render was stopped by an interrupt before it was done.
    #[getter]
    fn interrupted(&self) -> bool {
        self.interrupted
    }

    /// How the image was made, as in the attributes of its file: scene, integrator, sampler, sampleRanges ...
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, value) in self.metadata.attributes() {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// The array of a layer: float32 of the shape (height, width) or (height, width, channels), uint32 for counts. The
    /// image's own array, not a copy.
    ///
    /// Raises KeyError when there is no such layer.
    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        Ok(match &self.layer(name)?.data {
            Data::Float(array) => array.clone_ref(py).into_any(),
            Data::Count(array) => array.clone_ref(py).into_any(),
        })
    }

    fn __contains__(&self, name: &str) -> bool {
        self.layers.iter().any(|layer| layer.name == name)
    }

    /// The radiance, so that numpy takes an image where it takes an array.
    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let array = self.radiance(py)?.into_bound(py);
        match (dtype, copy) {
            (None, Some(true)) => array.call_method0("copy"),
            (None, _) => Ok(array),
            (Some(dtype), copy) => {
                let options = PyDict::new(py);
                options.set_item("copy", copy.unwrap_or(false))?;
                array.call_method("astype", (dtype,), Some(&options))
            }
        }
    }

    /// Writes an OpenEXR file with all layers and the record of how the image was made.
    ///
    /// Raises OSError when the file cannot be written.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let image = self.to_layered(py)?;
        py.detach(|| write_exr(&path, &image, false))
            .map_err(file_error)
    }

    fn __repr__(&self) -> String {
        format!(
            "<halflight.Image {} x {}, {} samples per pixel, layers {}>",
            self.width,
            self.height,
            self.metadata.spp,
            self.layers().join(", ")
        )
    }
}

/// Reads an OpenEXR file with all its layers.
///
/// Raises OSError when the file cannot be read or is damaged.
#[pyfunction]
pub(crate) fn read(py: Python<'_>, path: PathBuf) -> PyResult<PyImage> {
    let mut image = py.detach(|| read_exr(&path)).map_err(file_error)?;
    // Counts that are all the same stand in an attribute.
    if image.channel("samples").is_none()
        && let Some(counts) = image.sample_counts()
    {
        let counts = counts.into_owned();
        image.channels.push(("samples".to_owned(), counts));
    }
    let find = |name: &str| image.attribute(name).map(str::to_owned);
    let metadata = ImageMetadata::from_attributes(find).map_err(value_error)?;
    let planes = image.channels.into_iter().map(|(name, values)| {
        // Counts of samples are whole numbers, which a float holds exactly up to 2^24.
        let is_count = name == "samples" && values.iter().all(|v| v.fract() == 0.0 && *v >= 0.0);
        let plane = if is_count {
            Plane::Count(values.into_iter().map(|v| v as u32).collect())
        } else {
            Plane::Float(values)
        };
        (name, plane)
    });
    Ok(PyImage {
        layers: layers(
            py,
            planes.collect(),
            image.width as usize,
            image.height as usize,
        )?,
        width: image.width,
        height: image.height,
        offset: image.origin,
        full_size: image.display_size,
        metadata,
        interrupted: false,
    })
}

/// The image of an array of the shape (height, width, 3).
pub(crate) fn exr_of_array(array: &Bound<'_, PyAny>) -> PyResult<ExrImage> {
    let wrong =
        || value_error("expected an image, a path, or an array of the shape (height, width, 3)");
    let numpy = array.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (array, "float32"))?;
    let array = array.cast_into::<PyArrayDyn<f32>>().map_err(|_| wrong())?;
    let &[height, width, 3] = array.shape() else {
        return Err(wrong());
    };
    let flat: Bound<'_, PyArray1<f32>> = array.reshape([height * width * 3])?;
    let values = flat.readonly();
    let values = values.as_slice().map_err(value_error)?;
    let side = |n: usize| u32::try_from(n).map_err(|_| wrong());
    let plane = |c: usize| values.iter().skip(c).step_by(3).copied().collect();
    let (width, height) = (side(width)?, side(height)?);
    Ok(ExrImage {
        width,
        height,
        origin: [0; 2],
        display_size: [width, height],
        channels: ["R", "G", "B"]
            .into_iter()
            .enumerate()
            .map(|(c, name)| (name.to_owned(), plane(c)))
            .collect(),
        attributes: Vec::new(),
        warnings: Vec::new(),
    })
}
