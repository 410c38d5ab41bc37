//! Every class of [Z1] §VI and §VII is inhabitable, and computes with exactly its arguments.

use agent::args::{Args, C0, E, F, On, T, Union, V};
use agent::{
    And, Behaviour, Class, Condition, Constant, Generator, Inhabitant, Input, Kind, Move, Not, Or,
    Step, X, condition, generator, missing, widen,
};

use crate::cell::{Arm, Mp, arm};

/// A generator and a condition of the arm for each list; the demand is the sum of what is read.
macro_rules! arm_classes {
    ($($gen:ident $cond:ident: F<$c:tt, $e:tt, $v:tt $(, $t:tt)?> = |$x:ident| $sum:expr;)+) => { $(
        struct $gen;
        impl Generator<Arm> for $gen {
            type Own = u32;
            type Args = F<$c, $e, $v $(, $t)?>;
            fn first(&self, $x: X<'_, Arm, Self::Args>) -> (u32, f64) {
                let _ = $x;
                (1, $sum)
            }
            fn next(&self, n: &mut u32, $x: X<'_, Arm, Self::Args>) -> f64 {
                let _ = $x;
                *n += 1;
                $sum
            }
            fn terminal(&self, n: &u32, _: X<'_, Arm, Self::Args>) -> bool {
                *n >= 2
            }
        }
        struct $cond;
        impl Condition<Arm> for $cond {
            type Args = F<$c, $e, $v $(, $t)?>;
            fn holds(&self, $x: X<'_, Arm, Self::Args>) -> bool {
                let _ = $x;
                $sum > 0.5
            }
        }
    )+ };
}
arm_classes! {
    G0 P0: F<(), (), ()> = |x| 0.0;
    G1 P1: F<(), (), V> = |x| *x.v();
    G2 P2: F<(), E, ()> = |x| *x.e();
    G3 P3: F<(), E, V> = |x| x.e() + x.v();
    G4 P4: F<C0, (), ()> = |x| *x.c0();
    G5 P5: F<C0, (), V> = |x| x.c0() + x.v();
    G6 P6: F<C0, E, ()> = |x| x.c0() + x.e();
    G7 P7: F<C0, E, V> = |x| x.c0() + x.e() + x.v();
    G2T P2T: F<(), E, (), T> = |x| x.e() + x.t();
}

macro_rules! mp_classes {
    ($($gen:ident $cond:ident: F<(), $e:tt, $v:tt> = |$x:ident| $y:expr;)+) => { $(
        struct $gen;
        impl Generator<Mp> for $gen {
            type Own = ();
            type Args = F<(), $e, $v>;
            fn first(&self, $x: X<'_, Mp, Self::Args>) -> ((), [f64; 2]) {
                let _ = $x;
                ((), $y)
            }
            fn next(&self, (): &mut (), x: X<'_, Mp, Self::Args>) -> [f64; 2] {
                self.first(x).1
            }
            fn terminal(&self, (): &(), _: X<'_, Mp, Self::Args>) -> bool {
                false
            }
        }
        struct $cond;
        impl Condition<Mp> for $cond {
            type Args = F<(), $e, $v>;
            fn holds(&self, $x: X<'_, Mp, Self::Args>) -> bool {
                let _ = $x;
                $y[0] > 0.0
            }
        }
    )+ };
}
mp_classes! {
    M0 Q0: F<(), (), ()> = |x| [0.0; 2];
    M1 Q1: F<(), (), V> = |x| [*x.v(); 2];
    M2 Q2: F<(), E, ()> = |x| *x.e();
    M3 Q3: F<(), E, V> = |x| x.e().map(|e| e + x.v());
}

const CENSUS: [Inhabitant; 25] = [
    Inhabitant::generator::<Mp, M0>("M0"),
    Inhabitant::generator::<Mp, M1>("M1"),
    Inhabitant::generator::<Mp, M2>("M2"),
    Inhabitant::generator::<Mp, M3>("M3"),
    Inhabitant::generator::<Mp, Constant<[f64; 2]>>("Constant"),
    Inhabitant::generator::<Arm, G0>("G0"),
    Inhabitant::generator::<Arm, G1>("G1"),
    Inhabitant::generator::<Arm, G2>("G2"),
    Inhabitant::generator::<Arm, G3>("G3"),
    Inhabitant::generator::<Arm, G4>("G4"),
    Inhabitant::generator::<Arm, G5>("G5"),
    Inhabitant::generator::<Arm, G6>("G6"),
    Inhabitant::generator::<Arm, G7>("G7"),
    Inhabitant::condition::<Mp, Q0>("Q0"),
    Inhabitant::condition::<Mp, Q1>("Q1"),
    Inhabitant::condition::<Mp, Q2>("Q2"),
    Inhabitant::condition::<Mp, Q3>("Q3"),
    Inhabitant::condition::<Arm, P0>("P0"),
    Inhabitant::condition::<Arm, P1>("P1"),
    Inhabitant::condition::<Arm, P2>("P2"),
    Inhabitant::condition::<Arm, P3>("P3"),
    Inhabitant::condition::<Arm, P4>("P4"),
    Inhabitant::condition::<Arm, P5>("P5"),
    Inhabitant::condition::<Arm, P6>("P6"),
    Inhabitant::condition::<Arm, P7>("P7"),
];

// A class is a constant: a table of them costs nothing at run time.
const _: () = assert!(matches!(Class::generator::<Arm, G6>().q(), Some(6)));

#[test]
fn five_and_eight_generators_four_and_eight_conditions_and_none_twice() {
    let all: Vec<_> = Class::all().collect();
    assert_eq!(all.len(), 5 + 8 + 4 + 8);
    assert!((1..all.len()).all(|n| !all[n..].contains(&all[n - 1])));
    let generators = all.iter().filter(|c| c.kind() == Kind::Generator).count();
    assert_eq!(generators, 13);
}

#[test]
fn every_class_has_an_inhabitant_here() {
    assert_eq!(missing(&CENSUS).collect::<Vec<_>>(), []);
}

#[test]
fn the_census_notices_each_class_that_is_lost() {
    for lost in 0..CENSUS.len() {
        let mut census = CENSUS.to_vec();
        let lost = census.remove(lost);
        assert_eq!(missing(&census).collect::<Vec<_>>(), [lost.class]);
    }
    assert_eq!(missing(&[]).count(), 25);
}

#[test]
fn a_reader_of_transmissions_is_in_no_class_of_the_first_paper() {
    let with_t = Inhabitant::generator::<Arm, G2T>("G2T");
    assert_eq!(with_t.to_string(), "G2T: f^2(c_j, e_j, T_j)");
    let mut census = CENSUS.to_vec();
    census.retain(|entry| entry.name != "G2");
    census.push(with_t);
    assert_eq!(
        missing(&census).collect::<Vec<_>>(),
        [Class::ECP_GENERATORS[2]]
    );
}

#[test]
fn classes_print_as_the_papers_write_them() {
    let names: Vec<_> = Class::all().map(|class| class.to_string()).collect();
    assert_eq!(
        names,
        [
            "f^0(c_0)",
            "f^1(c_0, v_0)",
            "f^2(c_0, e_c)",
            "f^3(c_0, e_c, v_0)",
            "f**() = const",
            "f^0(c_j)",
            "f^1(c_j, v_j)",
            "f^2(c_j, e_j)",
            "f^3(c_j, e_j, v_j)",
            "f^4(c_0, c_j)",
            "f^5(c_0, c_j, v_j)",
            "f^6(c_0, c_j, e_j)",
            "f^7(c_0, c_j, e_j, v_j)",
            "f_P^0(c_0)",
            "f_P^1(c_0, v_0)",
            "f_P^2(c_0, e_c)",
            "f_P^3(c_0, e_c, v_0)",
            "f_P^0(c_j)",
            "f_P^1(c_j, v_j)",
            "f_P^2(c_j, e_j)",
            "f_P^3(c_j, e_j, v_j)",
            "f_P^4(c_0, c_j)",
            "f_P^5(c_0, c_j, v_j)",
            "f_P^6(c_0, c_j, e_j)",
            "f_P^7(c_0, c_j, e_j, v_j)",
        ]
    );
}

#[test]
fn a_class_reads_what_it_lists() {
    fn first<G: Generator<Arm>>(g: G) -> Step<f64> {
        Move::new(g).step(&arm(0, 100.0))
    }
    assert_eq!(first(G0), Step::Demand(0.0));
    assert_eq!(first(G1), Step::Demand(100.0));
    assert_eq!(first(G2), Step::Demand(1.0));
    assert_eq!(first(G3), Step::Demand(101.0));
    assert_eq!(first(G4), Step::Demand(10.0));
    assert_eq!(first(G5), Step::Demand(110.0));
    assert_eq!(first(G6), Step::Demand(11.0));
    assert_eq!(first(G7), Step::Demand(111.0));
    assert_eq!(first(G2T), Step::Demand(1001.0));
}

#[test]
fn closures_have_the_class_they_declare() {
    let g = generator::<Arm, F<C0, (), V>, _, _, _, _>(|_| ((), 0.0), |(), _| 0.0, |(), _| true);
    assert_eq!(Class::of_generator::<Arm, _>(&g), Class::ECP_GENERATORS[5]);
    let p = condition::<Arm, F<(), E, V>, _>(|_| true);
    assert_eq!(Class::of_condition::<Arm, _>(&p), Class::ECP_CONDITIONS[3]);
    assert_eq!(
        Class::of_condition::<Arm, _>(&widen::<F<C0, E, V>, _>(p)).q(),
        Some(7)
    );
}

/// `q` of `And`, `Or` of every pair of lists is the bitwise union; `Not` keeps it.
#[test]
fn a_composed_condition_has_the_union_class() {
    fn pair<
        A: Condition<Arm, Args: Union<B::Args, Of: On<agent::args::Executor>>>,
        B: Condition<Arm>,
    >(
        _: &A,
        _: &B,
    ) {
        let q = |class: Class| class.q().unwrap();
        let (a, b) = (Class::condition::<Arm, A>(), Class::condition::<Arm, B>());
        let and = Class::condition::<Arm, And<A, B>>();
        let or = Class::condition::<Arm, Or<A, B>>();
        assert_eq!(q(and), q(a) | q(b));
        assert_eq!(and.transmissions(), a.transmissions() || b.transmissions());
        assert_eq!(and, or);
        assert_eq!(Class::condition::<Arm, Not<A>>(), a);
        assert_eq!(<<A::Args as Union<B::Args>>::Of as Args>::CLASS, and.q());
    }
    macro_rules! pairs {
        ($($p:ident)+) => { $( pairs!(@with $p P0 P1 P2 P3 P4 P5 P6 P7 P2T); )+ };
        (@with $p:ident $($q:ident)+) => { $( pair(&$p, &$q); )+ };
    }
    pairs!(P0 P1 P2 P3 P4 P5 P6 P7 P2T);
}

#[test]
fn composed_conditions_decide_as_logic_does() {
    for (a, b) in [(false, false), (false, true), (true, false), (true, true)] {
        let x = Input::<Arm> {
            i: 0,
            c0: 0.0,
            e: f64::from(a),
            v: f64::from(b),
            t: 0.0,
        };
        assert_eq!(And(P2, P1).holds(x.seen_by()), a && b);
        assert_eq!(Or(P2, P1).holds(x.seen_by()), a || b);
        assert_eq!(Not(P2).holds(x.seen_by()), !a);
        assert_eq!(widen::<F<C0, E, V, T>, _>(P2).holds(x.seen_by()), a);
    }
}

#[test]
fn a_view_narrows_to_part_of_its_list() {
    let x = arm(3, 7.0);
    let all = x.seen_by::<F<C0, E, V, T>>();
    assert!(std::ptr::eq(
        all.narrow::<F<(), (), V>>().v(),
        &raw const x.v
    ));
    assert_eq!(all.narrow::<F<(), (), ()>>().i(), 3);
}
