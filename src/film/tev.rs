//! Pictures to the viewer tev (<https://github.com/Tom94/tev>) over its network protocol.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::Picture;
use crate::film::FilmError;

/// Where tev listens by default.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:14158";

/// How long to wait for a viewer to answer, and for it to take data.
const PATIENCE: Duration = Duration::from_secs(5);

/// Samples per packet; a viewer shows large pictures as they arrive.
const PACKET_SAMPLES: usize = 1 << 22;

/// A connection to a running tev.
pub struct Viewer {
    client: TevClient,
    address: String,
    /// Title and size of the picture last made there.
    shown: Option<(String, u32, u32)>,
}

impl Viewer {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// [`FilmError::Viewer`] when no viewer listens there.
    pub fn connect(address: &str) -> Result<Self, FilmError> {
        let connect = || {
            let mut last = io::Error::from(io::ErrorKind::AddrNotAvailable);
            for address in address.to_socket_addrs()? {
                match TcpStream::connect_timeout(&address, PATIENCE) {
                    Ok(stream) => {
                        stream.set_write_timeout(Some(PATIENCE))?;
                        return Ok(stream);
                    }
                    Err(error) => last = error,
                }
            }
            Err(last)
        };
        let stream = connect().map_err(|cause| FilmError::Viewer { address: address.to_owned(), cause })?;
        Ok(Self { client: TevClient::wrap(stream), address: address.to_owned(), shown: None })
    }

    /// Shows a picture with its layers under a title; a picture of the same title and size is updated in place.
    ///
    /// # Errors
    /// [`FilmError::Viewer`] when the connection breaks.
    pub fn show(&mut self, title: &str, picture: &Picture) -> Result<(), FilmError> {
        self.send(title, picture).map_err(|cause| FilmError::Viewer { address: self.address.clone(), cause })
    }

    fn send(&mut self, title: &str, picture: &Picture) -> io::Result<()> {
        let channels = channels(picture);
        let key = (title.to_owned(), picture.width, picture.height);
        if self.shown.as_ref() != Some(&key) {
            let channel_names: Vec<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
            self.client.send(PacketCreateImage {
                image_name: title,
                grab_focus: true,
                width: picture.width,
                height: picture.height,
                channel_names: &channel_names,
            })?;
            self.shown = Some(key);
        }
        let width = picture.width as usize;
        let rows = (PACKET_SAMPLES / width).max(1);
        for (name, samples) in &channels {
            for (strip, data) in samples.chunks(rows * width).enumerate() {
                self.client.send(PacketUpdateImage {
                    image_name: title,
                    grab_focus: false,
                    channel_names: &[name],
                    channel_offsets: &[0],
                    channel_strides: &[1],
                    x: 0,
                    y: (strip * rows) as u32,
                    width: picture.width,
                    height: (data.len() / width) as u32,
                    data,
                })?;
            }
        }
        Ok(())
    }
}

/// All channels by their full names.
fn channels(picture: &Picture) -> Vec<(String, Vec<f32>)> {
    let colors = ["R", "G", "B"].into_iter().enumerate();
    let colors =
        colors.map(|(c, name)| (name.to_owned(), picture.rgb.iter().map(|pixel| pixel[c]).collect()));
    let layers = picture.layers.iter().flat_map(|layer| {
        layer.channels.iter().map(|(name, samples)| (layer.full_name(name), samples.clone()))
    });
    colors.chain(layers).collect()
}
