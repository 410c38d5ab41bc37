//! Real-time scheduling, for those who may.

use crate::{End, exit};

/// Runs this process, and the threads it begins from now on, under `SCHED_FIFO` with this priority, 1 to 99, and keeps its
/// memory in RAM. To be called before threads are begun.
///
/// # Errors
/// Where the system has no such thing, or this user may not.
#[cfg(target_os = "linux")]
pub fn take_priority(priority: u8) -> Result<(), End> {
    use nix::sys::mman::{MlockAllFlags, mlockall};
    use std::io;
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };

    let refused = |what: &str, why: String, limit: &str| {
        let text = format!(
            "{what}: {why} (expected root, or {limit} of this user in /etc/security/limits.conf, got neither)"
        );
        End::new(exit::PERMISSION, text)
    };
    let value = ThreadPriorityValue::try_from(priority).map_err(End::usage)?;
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Crossplatform(value),
        ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
    )
    .map_err(|error| {
        let why = match error {
            thread_priority::Error::OS(code) => io::Error::from_raw_os_error(code).to_string(),
            other => other.to_string(),
        };
        refused("real-time priority", why, "an `rtprio`")
    })?;
    mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE)
        .map_err(|error| refused("locked memory", error.to_string(), "a `memlock`"))
}

/// As on Linux.
///
/// # Errors
/// Always: this system has no such thing, or nobody has tried.
#[cfg(not(target_os = "linux"))]
pub fn take_priority(_: u8) -> Result<(), End> {
    Err(End::new(
        exit::PERMISSION,
        "real-time priority: only on Linux",
    ))
}
