//! What waits to be written, and when the writer may take it.
//!
//! Where the solver has every core, a writer beside it costs what it computes. So it waits there, until the room for what waits
//! is half taken, and the rest is written when the run is over, on all cores. With a core to spare it takes everything at once.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::frame::Snapshot;

/// A snapshot that waits.
pub(super) struct Waiting {
    pub(super) snapshot: Snapshot,
    /// It lies beside the checkpoint already.
    pub(super) shelved: bool,
}

/// Snapshots on their way to the writer, in their order.
pub(super) struct Queue {
    line: Mutex<Line>,
    changed: Condvar,
    /// Bytes that may wait.
    room: usize,
    /// Whether a core is left for the writer.
    spare: bool,
}

#[derive(Default)]
struct Line {
    waiting: VecDeque<Waiting>,
    /// Of those that wait.
    bytes: usize,
    /// The writer works on one.
    busy: bool,
    /// The writer has failed, or is to stop.
    closed: bool,
}

impl Queue {
    pub(super) fn new(room: usize, spare: bool) -> Self {
        Self { line: Mutex::default(), changed: Condvar::new(), room, spare }
    }

    fn line(&self) -> MutexGuard<'_, Line> {
        // Nothing here panics half-way through a change.
        self.line.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_while(&self, unless: impl Fn(&Line) -> bool) -> MutexGuard<'_, Line> {
        self.changed.wait_while(self.line(), |line| unless(line)).unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a snapshot, when there is room for it; to a writer that has failed, nothing.
    pub(super) fn push(&self, snapshot: Snapshot) {
        let bytes = snapshot.bytes();
        let mut line = self.wait_while(|line| {
            let full = line.bytes + bytes > self.room && !line.waiting.is_empty();
            full && !line.closed
        });
        if !line.closed {
            line.bytes += bytes;
            line.waiting.push_back(Waiting { snapshot, shelved: false });
            self.changed.notify_all();
        }
    }

    /// The next one for the writer, when it may take one; none when it is to stop.
    pub(super) fn take(&self) -> Option<Waiting> {
        let mut line = self.line();
        line.busy = false;
        self.changed.notify_all();
        drop(line);
        let mut line = self.wait_while(|line| {
            let may = !line.waiting.is_empty() && (self.spare || line.bytes > self.room / 2);
            !may && !line.closed
        });
        if line.closed {
            return None;
        }
        let next = line.waiting.pop_front()?;
        line.bytes -= next.snapshot.bytes();
        line.busy = true;
        self.changed.notify_all();
        Some(next)
    }

    /// Does something with all that wait, while the writer has none in hand.
    pub(super) fn hold<T>(&self, work: impl FnOnce(&mut VecDeque<Waiting>) -> T) -> T {
        work(&mut self.wait_while(|line| line.busy).waiting)
    }

    /// Lets nothing in or out any more.
    pub(super) fn close(&self) {
        let mut line = self.line();
        line.closed = true;
        line.busy = false;
        self.changed.notify_all();
    }

    /// What still waits.
    pub(super) fn rest(&self) -> VecDeque<Waiting> {
        let mut line = self.line();
        line.bytes = 0;
        std::mem::take(&mut line.waiting)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
    use std::thread;
    use std::time::Duration;

    use super::*;
    use crate::case;
    use crate::frame::Camera;
    use crate::simulation::Simulation;

    /// Snapshots of a small ply that has been hit, all of one size, by index.
    fn snapshots(count: usize) -> Vec<Snapshot> {
        let sets = ["/pack/width_mm=11.43", "/pack/height_mm=11.43", "/expect=[]"].map(str::to_owned);
        let case = case::read(Path::new("cases/s720-1ply-155.json"), &sets);
        let case = case.unwrap_or_else(|error| unreachable!("{error}"));
        let simulation = Simulation::<f64>::new(&case);
        let mut simulation = simulation.unwrap_or_else(|error| unreachable!("{error}"));
        for _ in 0..30 {
            simulation.advance(&case);
        }
        let mut camera = Camera::new(count, case.solver.end_time);
        (0..count).map(|_| camera.take(&simulation.view())).collect()
    }

    /// A writer that takes what it may, and the indices of what it has taken.
    fn writer(queue: &Arc<Queue>) -> Receiver<usize> {
        let (taken, told) = mpsc::channel();
        let queue = queue.clone();
        thread::spawn(move || {
            while let Some(next) = queue.take() {
                if taken.send(next.snapshot.frame().index).is_err() {
                    break;
                }
            }
        });
        told
    }

    const SOON: Duration = Duration::from_millis(100);
    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn a_writer_with_a_core_of_its_own_takes_everything_at_once() {
        let queue = Arc::new(Queue::new(usize::MAX, true));
        let told = writer(&queue);
        for (index, snapshot) in snapshots(3).into_iter().enumerate() {
            queue.push(snapshot);
            assert_eq!(told.recv_timeout(LONG), Ok(index));
        }
        queue.close();
        assert!(queue.rest().is_empty());
    }

    #[test]
    fn a_writer_without_one_takes_what_half_the_room_does_not_hold() {
        let snapshots = snapshots(7);
        let one = snapshots[0].bytes();
        assert!(one > 9 * 9 * 10 * size_of::<f64>() / 4, "{one}");
        let queue = Arc::new(Queue::new(8 * one, false));
        let told = writer(&queue);
        snapshots.into_iter().for_each(|snapshot| queue.push(snapshot));
        assert_eq!([0; 3].map(|_| told.recv_timeout(LONG)), [Ok(0), Ok(1), Ok(2)]);
        assert_eq!(told.recv_timeout(SOON), Err(RecvTimeoutError::Timeout));
        let shelved = queue.hold(|waiting| {
            waiting.iter_mut().for_each(|frame| frame.shelved = true);
            waiting.len()
        });
        assert_eq!(shelved, 4);
        queue.close();
        let rest: Vec<_> = queue.rest().into_iter().map(|next| (next.snapshot.frame().index, next.shelved)).collect();
        assert_eq!(rest, [(3, true), (4, true), (5, true), (6, true)]);
        assert_eq!(told.recv_timeout(LONG), Err(RecvTimeoutError::Disconnected));
    }

    #[test]
    fn the_solver_waits_for_room_and_not_for_a_writer_that_has_failed() {
        let snapshots = snapshots(4);
        let queue = Arc::new(Queue::new(2 * snapshots[0].bytes(), true));
        let (pushed, told) = mpsc::channel();
        let solver = queue.clone();
        thread::spawn(move || {
            for snapshot in snapshots {
                solver.push(snapshot);
                pushed.send(()).ok();
            }
        });
        assert_eq!([0; 2].map(|_| told.recv_timeout(LONG)), [Ok(()); 2]);
        assert_eq!(told.recv_timeout(SOON), Err(RecvTimeoutError::Timeout));
        assert!(queue.take().is_some());
        assert_eq!(told.recv_timeout(LONG), Ok(()));
        queue.close();
        assert_eq!(told.recv_timeout(LONG), Ok(()));
        assert_eq!(queue.rest().len(), 2);
    }
}
