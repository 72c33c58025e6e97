//! The image in the viewer tev while it is rendered.
//!
//! A thread of its own talks to the viewer, and takes one image at a time: one that does not read holds up nothing but itself.
//! Images that would wait behind another are left out, but for the last.

use super::preview_schedule::Schedule;
use crate::film::Film;
use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::time::{Duration, Instant};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// Longest time that a viewer may take to answer or to read.
const PATIENCE: Duration = Duration::from_secs(5);

/// Longest time that the end of a run waits for the viewer.
const LAST_PATIENCE: Duration = Duration::from_secs(2);

/// Time between two looks at whether it is ready.
const PAUSE: Duration = Duration::from_millis(10);

/// Values of a message to tev: it has the bytes of one in memory.
const VALUES_AT_A_TIME: usize = 3 << 22;

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// An image in tev.
pub(super) struct TevPreview {
    /// Images sent to the thread, until the last has gone.
    images: Option<SyncSender<Vec<f32>>>,
    /// How the thread ended.
    end: Receiver<io::Result<()>>,
    schedule: Schedule,
}

impl TevPreview {
    /// Connects to tev and makes an image there.
    ///
    /// # Errors
    /// If nothing listens at the address.
    pub fn connect(address: &str, name: String, film: &Film) -> Result<TevPreview, String> {
        let connect = || -> io::Result<TevClient> {
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
            Ok(client)
        };
        let mut client = connect().map_err(|error| format!("tev at {address}: {error}"))?;
        let (images, wanted) = mpsc::sync_channel::<Vec<f32>>(0);
        let (ended, end) = mpsc::channel();
        let width = film.width();
        std::thread::spawn(move || {
            let mut images = wanted.iter();
            let result = images.try_for_each(|image| send(&mut client, &name, width, &image));
            // Who has given up does not listen.
            let _ = ended.send(result);
        });
        Ok(TevPreview {
            images: Some(images),
            end,
            schedule: Schedule::new(),
        })
    }

    /// Shows the film if it is time, or if this is the last image.
    ///
    /// # Errors
    /// If the viewer is gone, or does not take the last image in time.
    pub fn show(&mut self, film: &Film, is_last: bool) -> io::Result<()> {
        let TevPreview {
            images,
            end,
            schedule,
        } = self;
        schedule.show(is_last, || {
            let Some(sender) = images else {
                return Ok(());
            };
            let values = film.statistics().iter().flat_map(|p| p.mean);
            let mut image: Vec<f32> = values.map(|v| v as f32).collect();
            let start = Instant::now();
            loop {
                match sender.try_send(image) {
                    Ok(()) => break,
                    Err(TrySendError::Disconnected(_)) => return end_of(end, Duration::ZERO),
                    // The thread waits for the viewer, or begins to wait for an image just now.
                    Err(TrySendError::Full(back)) => image = back,
                }
                if !is_last {
                    return Ok(());
                }
                if start.elapsed() > LAST_PATIENCE {
                    return Err(io::ErrorKind::TimedOut.into());
                }
                std::thread::sleep(PAUSE);
            }
            if is_last {
                *images = None;
                return end_of(end, LAST_PATIENCE.saturating_sub(start.elapsed()));
            }
            Ok(())
        })
    }
}

/// How the thread ended, which it may still do for some time.
fn end_of(end: &Receiver<io::Result<()>>, patience: Duration) -> io::Result<()> {
    end.recv_timeout(patience.max(PAUSE))
        .unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
}

/// Fills the image in tev.
fn send(client: &mut TevClient, name: &str, width: u32, image: &[f32]) -> io::Result<()> {
    let row = 3 * width as usize;
    let rows = (VALUES_AT_A_TIME / row).max(1);
    for (i, band) in image.chunks(rows * row).enumerate() {
        client.send(PacketUpdateImage {
            image_name: name,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3, 3, 3],
            x: 0,
            y: (i * rows) as u32,
            width,
            height: (band.len() / row) as u32,
            data: band,
        })?;
    }
    Ok(())
}
