//! Images to look at while they are rendered: in the viewer tev, or as a PNG that is rewritten.
//!
//! A preview that cannot be shown is said to be gone, once; the run goes on.

use crate::film::Film;
use crate::image::png_output::{Exposure, write_png};
use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// Shortest time between two images.
const INTERVAL: Duration = Duration::from_secs(1);

/// Share of the time that previews may take.
const SHARE: f64 = 0.1;

/// Longest time that a viewer may take to answer or to read.
const PATIENCE: Duration = Duration::from_secs(5);

/// Values of a message to tev: it has the bytes of one in memory.
const VALUES_AT_A_TIME: usize = 3 << 22;

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// When the next image is due.
struct Schedule {
    next: Instant,
}

impl Schedule {
    fn new() -> Schedule {
        Schedule {
            next: Instant::now(),
        }
    }

    /// Calls `show` if it is time, or if this is the last image.
    fn show<E>(&mut self, is_last: bool, show: impl FnOnce() -> Result<(), E>) -> Result<(), E> {
        let start = Instant::now();
        if start < self.next && !is_last {
            return Ok(());
        }
        let shown = show();
        let took = start.elapsed();
        self.next = Instant::now() + INTERVAL.max(took.div_f64(SHARE));
        shown
    }
}

/// An image in tev.
pub(super) struct TevPreview {
    client: TevClient,
    name: String,
    schedule: Schedule,
}

impl TevPreview {
    /// Connects to tev and makes an image there.
    ///
    /// # Errors
    /// If nobody listens.
    pub fn connect(address: &str, name: String, film: &Film) -> Result<TevPreview, String> {
        let connect = || -> io::Result<TevPreview> {
            let mut result = Err(io::Error::other("the address names no host"));
            for address in address.to_socket_addrs()? {
                result = TcpStream::connect_timeout(&address, PATIENCE);
                if result.is_ok() {
                    break;
                }
            }
            let socket = result?;
            socket.set_write_timeout(Some(PATIENCE))?;
            let mut client = TevClient::wrap(socket);
            client.send(PacketCreateImage {
                image_name: &name,
                grab_focus: true,
                width: film.width(),
                height: film.height(),
                channel_names: &CHANNELS,
            })?;
            Ok(TevPreview {
                client,
                name: name.clone(),
                schedule: Schedule::new(),
            })
        };
        connect().map_err(|error| format!("tev at {address}: {error}"))
    }

    fn show(&mut self, film: &Film, is_last: bool) -> io::Result<()> {
        let TevPreview {
            client,
            name,
            schedule,
        } = self;
        schedule.show(is_last, || {
            let width = film.width() as usize;
            let rows = (VALUES_AT_A_TIME / (3 * width)).max(1);
            for (i, band) in film.statistics().chunks(rows * width).enumerate() {
                let values = band.iter().flat_map(|p| p.mean.map(|v| v as f32));
                let data: Vec<f32> = values.collect();
                client.send(PacketUpdateImage {
                    image_name: name,
                    grab_focus: false,
                    channel_names: &CHANNELS,
                    channel_offsets: &[0, 1, 2],
                    channel_strides: &[3, 3, 3],
                    x: 0,
                    y: (i * rows) as u32,
                    width: film.width(),
                    height: (band.len() / width) as u32,
                    data: &data,
                })?;
            }
            Ok(())
        })
    }
}

/// A PNG that is rewritten.
pub(super) struct LivePng {
    path: PathBuf,
    exposure: Exposure,
    schedule: Schedule,
}

/// What shows the image while it is rendered.
#[derive(Default)]
pub(super) struct Previews {
    pub tev: Option<TevPreview>,
    pub png: Option<LivePng>,
}

impl LivePng {
    /// At a path.
    pub fn new(path: PathBuf, exposure: Exposure) -> LivePng {
        LivePng {
            path,
            exposure,
            schedule: Schedule::new(),
        }
    }
}

impl Previews {
    /// Shows the film, not too often unless it is the last time.
    pub fn show(&mut self, film: &Film, is_last: bool) {
        if let Some(tev) = &mut self.tev
            && let Err(error) = tev.show(film, is_last)
        {
            tracing::warn!("tev is gone: {error}");
            self.tev = None;
        }
        // The last PNG is written along with the image.
        if let Some(live) = self.png.as_mut().filter(|_| !is_last) {
            let (path, exposure) = (&live.path, live.exposure);
            let shown = live.schedule.show(false, || {
                write_png(path, film.width(), film.height(), &film.mean(), exposure)
            });
            if let Err(error) = shown {
                tracing::warn!("there is no live image: {error}");
                self.png = None;
            }
        }
    }
}
