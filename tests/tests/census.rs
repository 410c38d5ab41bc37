//! Every class of generators and conditions of the two papers has an inhabitant that is shipped.

use agent::Class;
use agent::args::Role;
use agent::class::Kind;

fn inhabitants() -> Vec<(Class, &'static str)> {
    let nodes = firmware::ecp::census::ECP
        .iter()
        .map(|entry| (entry.class, entry.name));
    nodes.chain(host::mp::census::census()).collect()
}

#[test]
fn every_class_has_an_inhabitant() {
    let inhabitants = inhabitants();
    for (role, kind, classes) in [
        (Role::Mp, Kind::Generator, 5),
        (Role::Ecp, Kind::Generator, 8),
        (Role::Mp, Kind::Condition, 4),
        (Role::Ecp, Kind::Condition, 8),
    ] {
        let mut inhabited: Vec<Class> = inhabitants
            .iter()
            .map(|(class, _)| *class)
            .filter(|class| class.role() == role && class.kind() == kind)
            .filter(|class| !class.transmissions())
            .collect();
        inhabited.sort_unstable();
        inhabited.dedup();
        assert_eq!(inhabited.len(), classes, "{role:?} {kind:?}: {inhabited:?}");
    }
}

#[test]
fn the_command_prints_the_same_census() {
    let output = mrroc_tests::binary::run(["classes", "--json"]);
    assert_eq!(output.code, Some(0), "{output:?}");
    let rows = output.json();
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 5 + 8 + 4 + 8);
    for (class, name) in inhabitants() {
        let level = format!("{:?}", class.role()).to_lowercase();
        let listed = rows.iter().any(|row| {
            row["class"] == class.to_string()
                && row["level"] == level
                && row["inhabitants"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .any(|n| n == name)
        });
        assert!(listed, "{class}: {name}");
    }
}
