//! The MP wire seen from outside: bytes, frames, and two endpoints talking.

mod wire {
    mod any;
    mod bytes;
    mod golden;
    mod link;
    mod maintenance;
    mod oracle;
    mod protection;
    mod samples;
    mod spec;
}
