//! What carries datagrams to a robot's daemon and from it.

/// Whom a datagram is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Channel {
    /// Other robots and the operator.
    Radio,
    /// The tracker.
    Tracker,
}

/// Carries datagrams. What is lost on the way is lost.
pub(crate) trait Air: Send {
    /// Sends a datagram to all other robots and to the operator.
    fn send(&mut self, datagram: &[u8]);

    /// Returns the next datagram that has come, if one has.
    fn receive(&mut self) -> Option<(Channel, Vec<u8>)>;
}
