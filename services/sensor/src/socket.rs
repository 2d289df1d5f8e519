//! A CAN socket: frames with the times at which the kernel received them, and how many it dropped.

use std::io::{Error, ErrorKind, IoSliceMut, Result};
use std::os::fd::AsRawFd;
use std::time::Duration;

use nix::sys::socket::{ControlMessageOwned, MsgFlags, recvmsg, setsockopt, sockopt};
use recording::can::Frame;
use socketcan::{CanFdSocket, Socket, SocketOptions};

/// Bytes of `struct canfd_frame`; a `struct can_frame` has 16. Both start with identifier and
/// flags, length, three other bytes, data.
const LARGEST: usize = 72;
const DATA: usize = 8;
/// Flags beside the identifier.
const EXTENDED: u32 = 1 << 31;
const NO_DATA: u32 = 0b11 << 29; // remote requests, errors
const IDENTIFIER: u32 = (1 << 29) - 1;
/// Receive buffer [bytes]: the kernel limits it, by default to some 500 frames.
const ROOM: usize = 4 << 20;

/// Result of reading the socket.
#[derive(Debug)]
pub(crate) enum BusRead<'a> {
    /// A data frame; its time is the time of day [ns].
    Frame(Frame<'a>),
    /// A frame without data.
    Other,
    /// No frame within the socket's time limit.
    Nothing,
}

/// An open interface.
#[derive(Debug)]
pub(crate) struct CanSocket {
    socket: CanFdSocket,
    /// Buffer of the kernel's time and count.
    control: Vec<u8>,
    /// The frame.
    data: [u8; LARGEST],
    /// Number of frames that the kernel dropped since the socket was opened, because they were not read.
    dropped: u32,
}

impl CanSocket {
    /// Opens `interface`; a read lasts at most `patience`. It also receives the frames of other nodes: they show that the bus
    /// is alive. So rows without values continue after a sensor falls silent, as they do from a log of the bus.
    pub(crate) fn open(interface: &str, patience: Duration) -> Result<Self> {
        let socket = CanFdSocket::open(interface)?;
        socket.set_error_filter_drop_all()?;
        socket.set_read_timeout(patience)?;
        setsockopt(&socket, sockopt::ReceiveTimestampns, &true)?;
        setsockopt(&socket, sockopt::RxqOvfl, &1)?;
        setsockopt(&socket, sockopt::RcvBuf, &ROOM)?;
        Ok(Self {
            socket,
            control: nix::cmsg_space!(nix::sys::time::TimeSpec, u32),
            data: [0; LARGEST],
            dropped: 0,
        })
    }

    /// The next frame, and the number of frames that the kernel dropped before it.
    pub(crate) fn read<'a>(&mut self, interface: &'a str) -> Result<(BusRead<'a>, u64)> {
        let mut space = [IoSliceMut::new(&mut self.data)];
        let fd = self.socket.as_raw_fd();
        let control = Some(self.control.as_mut_slice());
        let (mut time, mut dropped) = (None, self.dropped);
        let bytes = match recvmsg::<()>(fd, &mut space, control, MsgFlags::empty()) {
            Ok(message) => {
                for note in message.cmsgs()? {
                    match note {
                        ControlMessageOwned::ScmTimestampns(at) => time = Some(at),
                        ControlMessageOwned::RxqOvfl(count) => dropped = count,
                        _ => {}
                    }
                }
                message.bytes
            }
            Err(error) => {
                let error = Error::from(error);
                return match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {
                        Ok((BusRead::Nothing, 0))
                    }
                    _ => Err(error),
                };
            }
        };
        let lost = dropped.wrapping_sub(self.dropped);
        self.dropped = dropped;
        let time = time.ok_or_else(|| Error::other("the kernel gives no time of a frame"))?;
        let ns = time.tv_sec() * 1_000_000_000 + time.tv_nsec();
        let frame = frame(self.data.get(..bytes).unwrap_or_default(), ns, interface);
        Ok((frame.map_or(BusRead::Other, BusRead::Frame), lost.into()))
    }
}

/// The frame in the kernel's bytes; `None` if it is of a kind without data.
fn frame<'a>(bytes: &[u8], ns: i64, interface: &'a str) -> Option<Frame<'a>> {
    let (id, rest) = bytes.split_first_chunk()?;
    let id = u32::from_ne_bytes(*id);
    if id & NO_DATA != 0 {
        return None;
    }
    let length = usize::from(*rest.first()?);
    let data = bytes.get(DATA..DATA + length)?;
    Frame::new(ns, interface, id & IDENTIFIER, id & EXTENDED != 0, data)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(id: u32, length: u8, size: usize) -> Vec<u8> {
        let mut bytes = id.to_ne_bytes().to_vec();
        bytes.extend([length, 0, 0, 0]);
        bytes.extend((1..).take(size - bytes.len()));
        bytes
    }

    #[test]
    fn the_kernels_bytes_are_a_frame_or_nothing() {
        let read = |id, length, size| {
            let bytes = bytes(id, length, size);
            frame(&bytes, 5, "can0").map(|f| (f.id, f.extended, f.data().to_vec()))
        };
        assert_eq!(read(0x123, 2, 16), Some((0x123, false, vec![1, 2])));
        let long = read(EXTENDED | 0x18FE_F100, 64, 72).expect("a long frame");
        assert_eq!((long.0, long.1, long.2.len()), (0x18FE_F100, true, 64));
        assert_eq!(read(0x123 | 1 << 30, 2, 16), None, "a remote request");
        assert_eq!(read(0x123 | 1 << 29, 8, 16), None, "an error");
        assert_eq!(read(0x123, 9, 16), None, "a length beyond the frame");
        assert!(frame(&[1, 2, 3], 5, "can0").is_none());
    }
}
