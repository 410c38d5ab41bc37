//! Loose coordination: two arms run programs of their own, and decisions steer them.
//!
//! Each arm turns its column three times. Before every turn it waits for the Master Process to
//! decide which act is played; and the next act is decided when both arms are through with the last
//! one. What goes over the wire is an item of a finite set, not a motion.

use agent::args::{E, F};
use agent::{Class, Condition, Constant, Move, Sequence, Then, Wait, X};
use anyhow::Result;
use core::fmt::Write as _;
use firmware::ecp::condition::Decided;
use firmware::ecp::generator::JointMove;
use firmware::ecp::generator::axis_move::Course;
use firmware::ecp::{EcpOf, OneProgram};
use firmware::edp::EdpSetup;
use host::mp::behaviour::{sequence, start_programs};
use host::mp::command::{Commands, RobotCommand};
use host::mp::condition::AllDone;
use host::mp::robot::Image;
use host::mp::subsystem::{BoxedBehaviour, MpSubsystem};
use mrroc_examples::{Arm, STEP_S, World};
use protocol::message::Decision;
use protocol::units::PerAxis;
use robots::{Irp6Postument, Irp6Track, Joints, Motors, Robot};

/// Where an act turns the columns of the track's and of the postument's arm: rad from home.
const ACTS: [[f64; 2]; 3] = [[0.40, 0.15], [-0.10, -0.30], [0.0, 0.0]];
/// The decision that an act is played.
const LABELS: [u16; 3] = [1, 2, 3];
/// The column is the sixth joint from the tip of either arm.
const COLUMN: usize = 6;
/// The share of the motors' velocity that the nodes are configured with.
const VELOCITY_FACTOR: f64 = 0.2;

/// `f_P^4(c_0, c_j)`, then `f^2(c_j, e_j)`: wait for an act's decision, and play it.
type Act<R, const N: usize> = Then<Wait<Decided>, Move<JointMove<R, N>, Course<N>>>;

/// The node's only program, number 1: the acts, one after another.
type Play<R, const N: usize> = OneProgram<Sequence<[Act<R, N>; 3]>>;

/// `arm` is its index in [`ACTS`].
fn play<R: Robot<N> + Copy, const N: usize>(robot: R, arm: usize) -> Result<Play<R, N>> {
    let Joints(home) = robot.joints(&Motors([0.0; N]))?;
    let limits = EdpSetup::generator_limits(&robot, VELOCITY_FACTOR);
    let act = |k: usize| {
        let mut target = home;
        target[N - COLUMN] += ACTS[k][arm];
        let turn = JointMove {
            robot,
            target,
            relative: false,
            limits: limits.joints,
            motor_share: limits.motor_share,
            macrostep_s: STEP_S,
        };
        Then::new(Wait::new(Decided { label: LABELS[k] }), Move::new(turn))
    };
    Ok(OneProgram(Sequence::new([act(0), act(1), act(2)])))
}

/// `f_P^2(c_0, e_c)`: both arms are through with an act.
#[derive(Debug)]
struct Through {
    act: usize,
}

impl Condition<MpSubsystem> for Through {
    type Args = F<(), E, ()>;

    fn holds(&self, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        x.e()
            .iter()
            .enumerate()
            .all(|(arm, image)| is_through(image, arm, self.act))
    }
}

/// Does an arm demand of its column what the act asks for?
fn is_through(image: &Image, arm: usize, act: usize) -> bool {
    let home: PerAxis<f64> = image.arm().axes().iter().map(|_| 0.0).collect();
    let (home, now) = (image.arm().joints(&home), image.demanded_joints());
    home.ok().zip(now).is_some_and(|(home, now)| {
        let column = home.len() - COLUMN;
        (now[column] - home[column] - ACTS[act][arm]).abs() < 1e-5
    })
}

/// `f** = const`, then `f_P^2(c_0, e_c)`: decide on an act, and wait until both are through.
fn act(k: usize) -> BoxedBehaviour {
    let decision = RobotCommand::Loose(Decision {
        label: LABELS[k],
        variant: 0,
    });
    let tell = Commands {
        robots: vec![(0, decision.clone()), (1, decision)],
        give_up: None,
    };
    sequence(vec![
        Box::new(Move::new(Constant(tell))),
        Box::new(Wait::new(Through { act: k })),
    ])
}

/// The example, as the text it prints.
pub(crate) fn example() -> Result<String> {
    let track = Arm::track(play(Irp6Track::KEEP, 0)?)?;
    let postument = Arm::postument(play(Irp6Postument, 1)?)?;
    let mut world = World::new(vec![track, postument])?;
    world.get_ready()?;
    world.run(start_programs(&[0, 1], 1, 0.0))?;
    let mut text = format!(
        "the arms wait by {}, the MP by {}\n",
        Class::condition::<EcpOf<6>, Decided>(),
        Class::condition::<MpSubsystem, Through>(),
    );
    for (k, label) in LABELS.iter().enumerate() {
        let decided_s = world.now_s();
        let mut through_s = [None; 2];
        world.watch(act(k), |world| {
            for (arm, through) in through_s.iter_mut().enumerate() {
                let image = &world.mp.robots()[arm];
                if through.is_none() && is_through(image, arm, k) {
                    *through = Some(world.now_s() - decided_s);
                }
            }
        })?;
        let [track, postument] = through_s.map(|s| s.unwrap_or(f64::NAN));
        let next = world.now_s() - decided_s;
        writeln!(
            text,
            "act {label}: track through after {track:.2} s, postument after {postument:.2} s, \
             both after {next:.2} s"
        )?;
    }
    world.run(Box::new(Wait::new(AllDone { robots: vec![0, 1] })))?;
    writeln!(text, "{} faults", world.faults())?;
    Ok(text)
}

fn main() -> Result<()> {
    print!("{}", example()?);
    Ok(())
}
