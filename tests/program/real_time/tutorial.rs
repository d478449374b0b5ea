//! The tutorial that drives a robot, an emulated one: it is typed as `documented` types the others.

#[test]
fn first_drive() {
    crate::documented::type_page_with_robot();
}
