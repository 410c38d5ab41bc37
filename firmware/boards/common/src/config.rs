//! Which node a board makes: what its flash says, or what its image says where flash says nothing.

use crate::boot::Boot;
use crate::store::Store;
use embedded_storage::nor_flash::NorFlash;
use protocol::time::Micros;

/// Of what the content of the store means: [`Boot::write`].
pub const VERSION: u16 = 1;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The node to be made; nothing if this image knows no robot.
    pub boot: Option<Boot>,
    /// It is in flash, twice. If not, the flash is broken.
    pub stored: bool,
}

/// What is in this flash. With `anew`, or if there is nothing that can be read, it is what the image says; and whatever
/// it is, it is in flash twice from now on.
pub fn load<F: NorFlash>(flash: F, anew: bool) -> Found {
    let mut store = Store::new(flash, VERSION);
    let loaded = store.load().filter(|_| !anew);
    let twice = loaded.as_ref().is_some_and(|loaded| loaded.twice);
    let read = loaded.and_then(|loaded| Boot::read(&loaded.content));
    let stored = twice && read.is_some();
    let Some(boot) = read.or_else(|| Boot::unconfigured(Micros(0))) else {
        return Found {
            boot: None,
            stored: false,
        };
    };
    let mut content = [0; Boot::BYTES];
    let stored = stored || boot.write(&mut content).is_some() && store.save(&content).is_ok();
    Found {
        boot: Some(boot),
        stored,
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::store::test::Torn;
    use robots::RobotKind;

    fn configured() -> Boot {
        let mut boot = Boot::unconfigured(Micros(0)).unwrap();
        boot.kind = RobotKind::Conveyor;
        boot.station.velocity_factor = 0.75;
        boot.buses.truncate(1);
        boot
    }

    fn saved(boot: &Boot) -> Torn {
        let mut content = [0; Boot::BYTES];
        let _ = boot.write(&mut content).unwrap();
        let mut store = Store::new(Torn::new(), VERSION);
        store.save(&content).unwrap();
        store.flash
    }

    #[test]
    fn what_flash_says_is_taken_unless_one_asks_for_the_images_own() {
        let mut flash = saved(&configured());
        let found = load(&mut flash, false);
        assert_eq!((found.boot, found.stored), (Some(configured()), true));
        let own = Boot::unconfigured(Micros(0));
        assert_ne!(own, Some(configured()));
        assert_eq!(load(&mut flash, true).boot, own);
        assert_eq!(load(&mut flash, false).boot, own, "it is stored");
    }

    #[test]
    fn a_flash_of_anything_gets_what_the_image_says() {
        let mut flash = Torn::new();
        let own = Boot::unconfigured(Micros(0));
        for _ in 0..2 {
            let found = load(&mut flash, false);
            assert_eq!((found.boot, found.stored), (own.clone(), true));
        }
    }

    #[test]
    fn a_copy_that_rotted_is_mended() {
        let mut flash = saved(&configured());
        flash.rot(40);
        assert_eq!(load(&mut flash, false).boot, Some(configured()));
        let mut store = Store::new(&mut flash, VERSION);
        assert!(store.load().unwrap().twice);
    }

    #[test]
    fn a_broken_flash_is_told_and_there_is_a_node_all_the_same() {
        let mut flash = Torn::new();
        flash.cut_after(1);
        let found = load(&mut flash, false);
        assert_eq!(
            (found.boot, found.stored),
            (Boot::unconfigured(Micros(0)), false)
        );
    }
}
