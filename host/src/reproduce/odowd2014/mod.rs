//! The study of O'Dowd, Studley and Winfield (2014).

pub(crate) mod results;
