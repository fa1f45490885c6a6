//! Curves that touch: cams and their followers, what rolls, rubs, lifts off and lands, slots and Geneva wheels.

mod cams;
mod curves;
mod followers;
mod geneva;
mod leaving;
mod lifting;
mod rolling;
mod rubbing;
mod space;
