//! The nod of the first example again, computed by the Master Process: tight coordination.
//!
//! The node only interpolates between the knots it is sent, one per macrostep, `knot_lead_steps`
//! ahead of their instant. That costs bus load and gains a view of all robots.

#[path = "01_own_generator.rs"]
#[expect(dead_code, reason = "its own main")]
pub(crate) mod own_generator;

use agent::args::{E, F};
use agent::{Class, Generator, Move, X};
use anyhow::Result;
use host::mp::arm::AxisMotion;
use host::mp::behaviour::tight;
use host::mp::command::{Commands, RobotCommand};
use host::mp::config::Grid;
use host::mp::failure::Failure;
use host::mp::generator::knot;
use host::mp::subsystem::MpSubsystem;
use mrroc_examples::{Arm, DURATION_S, STEP_S, WRIST, World, apart, nod, summary};
use protocol::units::PerAxis;

/// `f^2(c_0, e_c)`: nod from wherever the arm stands.
#[derive(Debug)]
struct Nod {
    grid: Grid,
    lead: u32,
}

/// `c_0`: where it began, the instant of the first knot, and how many knots were sent.
#[derive(Debug)]
struct Own {
    from: PerAxis<f64>,
    begin: u32,
    sent: u32,
}

impl Generator<MpSubsystem> for Nod {
    type Own = Own;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, MpSubsystem, Self::Args>) -> (Own, Commands) {
        let image = &x.e()[0];
        let mut c = Own {
            from: PerAxis::new(),
            begin: x.i() + self.lead,
            sent: 0,
        };
        if let Some(from) = image.demanded_joints() {
            c.from = from;
            let y = self.next(&mut c, x);
            return (c, y);
        }
        let (who, span_ms) = (image.who(), 0);
        (c, Commands::give_up(Failure::Lost { who, span_ms }))
    }

    fn next(&self, c: &mut Own, x: X<'_, MpSubsystem, Self::Args>) -> Commands {
        let mut knots = Vec::new();
        // one knot, or more where instants were left out
        while c.begin + c.sent <= x.i() + self.lead && f64::from(c.sent) * STEP_S <= DURATION_S {
            let [p, v, a] = nod(f64::from(c.sent) * STEP_S);
            let rest: PerAxis<f64> = c.from.iter().map(|_| 0.0).collect();
            let mut to = AxisMotion {
                position: c.from.clone(),
                velocity: rest.clone(),
                acceleration: rest,
            };
            to.position[WRIST] += p;
            to.velocity[WRIST] = v;
            to.acceleration[WRIST] = a;
            knots.push(knot(self.grid.at(c.begin + c.sent), &to));
            c.sent += 1;
        }
        Commands::one(0, RobotCommand::Tight(knots))
    }

    fn terminal(&self, c: &Own, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        f64::from(c.sent) * STEP_S > DURATION_S && x.i() > c.begin + c.sent
    }
}

/// Runs it; gives where the wrist really was, at every servo step.
fn run(world: &mut World) -> Result<Vec<f64>> {
    let (grid, lead) = (world.mp.grid(), world.mp.config().timing.knot_lead_steps);
    let mut wrist = Vec::new();
    let nod = Box::new(Move::new(Nod { grid, lead }));
    world.watch(tight(&[0], nod, grid), |world| {
        wrist.extend(world.joints(0).map(|joints| joints[WRIST]));
    })?;
    Ok(wrist)
}

/// The example, as the text it prints.
pub(crate) fn example() -> Result<String> {
    let mut world = World::new(vec![Arm::postument(own_generator::linked())?])?;
    world.get_ready()?;
    let on_the_node = own_generator::run(&mut world)?;
    let on_the_mp = run(&mut world)?;
    Ok(format!(
        "Move by {}\n{}\n{}\napart by {:.1} mrad at most, {} faults\n",
        Class::generator::<MpSubsystem, Nod>(),
        summary("wrist by the node", &on_the_node),
        summary("wrist by the MP  ", &on_the_mp),
        1e3 * apart(&on_the_node, &on_the_mp),
        world.faults(),
    ))
}

fn main() -> Result<()> {
    print!("{}", example()?);
    Ok(())
}
