//! EvoStick's missions: published networks replayed, missions beside their rules, and its runs.

mod place;
use place::Place;

#[test]
fn first() {
    let place = Place::new("first");
    place.good(&["--version"]);
}
