//! What drives in the field do otherwise: the node survives it, or refuses with the cause that says so.

use super::*;
use hil_sim::drive::quirk::Quirk;

/// Sets the node up with drives of one quirk, lets it enable and home if it can; the fault it ends with.
fn meet(quirk: Quirk) -> (Coordinator, Option<Cause>) {
    let quirks = Quirks::default().with(quirk);
    let mut c = Coordinator::with(RobotKind::Irp6Postument, ServoLaw::DrivePosition, quirks);
    let mut enabled = false;
    // 2 s of booting, then homing of six axes one after the other
    for _ in 0..6000 {
        c.macrostep(&mut ());
        let Some(feedback) = &c.feedback else {
            continue;
        };
        if let Some(fault) = feedback.fault {
            return (c, Some(fault.cause));
        }
        match feedback.state {
            NodeState::Disabled if !enabled => {
                enabled = true;
                let acquire = Request::Acquire {
                    nonce: 1,
                    lease_ms: 100,
                    takeover: false,
                };
                let Reply::Lease { epoch } = c.request(&acquire) else {
                    panic!("no lease")
                };
                c.epoch = epoch;
                let _ = c.request(&Request::Enable { epoch });
            }
            NodeState::Unsynchronised => {
                let epoch = c.epoch;
                let _ = c.request(&Request::Synchronise { epoch });
            }
            NodeState::Holding => return (c, None),
            _ => {}
        }
    }
    panic!("{quirk:?}: neither homed nor a fault: {:?}", c.feedback);
}

#[test]
fn each_quirk_is_survived_or_refused_with_its_cause() {
    for quirk in Quirk::ALL {
        let expected = match quirk {
            // The node waits longer than that; homes the axes itself; SYNC comes in time; and what a drive
            // told before its reset was over is of the past.
            Quirk::SlowBoot
            | Quirk::SlowAnswers
            | Quirk::HomingNeverReached
            | Quirk::TightSync
            // nobody asks for it, nobody sets a layer of drives that have node ids
            | Quirk::NoVerifyConfiguration
            | Quirk::ForgetsNode
            | Quirk::SlowLayer
            | Quirk::EmergencyBeforeBootUp => None,
            // without the period the drive would interpolate wrongly
            Quirk::NoInterpolationPeriod => Some(Cause::DriveConfiguration),
            // an axis that moves by itself goes away from where it is told
            Quirk::HomesItself => Some(Cause::Runaway),
            // a PDO of another length is none
            Quirk::ShortPdo => Some(Cause::DriveSilent),
            // it never stays enabled; old faults are being reset meanwhile
            Quirk::FlickeringFault => Some(Cause::DriveDisabled),
        };
        let (c, cause) = meet(quirk);
        assert_eq!(cause, expected, "{quirk:?}: {:?}", c.feedback);
        assert_eq!(c.cell.refused(), [], "{quirk:?}");
    }
}
