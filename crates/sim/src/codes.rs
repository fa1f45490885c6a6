//! Codes of faults found after reading: at the start and during the run.

bksim_model::codes! {
    CANNOT_CLOSE = "S001", "a loop cannot close";
    STATED_POSITIONS = "S002", "stated positions exclude each other";
    STATED_VELOCITIES = "S003", "stated rates exclude each other";
    DRIVE_AT_START = "S004", "a drive cannot move at the start";
    NO_INERTIA = "S005", "a motion without inertia";
    NOT_FINITE_AT_START = "S006", "no finite value at the start";
    BEYOND_STOP = "S007", "a start beyond a stop";
    IRREVERSIBLE = "S008", "back in time over what switches";
    REDUNDANT = "S010", "redundant joints";
    NO_MOBILITY = "S011", "nothing can move";
    NO_SENSITIVITY = "S012", "a sensitivity that does not exist";
    INPUT_ELSEWHERE = "S013", "an input that not only loads depend on";
    GUESS_MOVED = "S014", "a guess far off";
    AMBIGUOUS = "S015", "another assembly nearly as near";
    DRIVE_OUT_OF_REACH = "S016", "a drive starts out of reach";
    TOO_MUCH = "S020", "a run without an end";
    UNCOUNTED_TURNS = "S021", "turns that cannot be counted";
    CENTRE_DISTANCE = "S022", "wheels that do not fit their centres";
    SHARED_REACTION = "S023", "friction by a reaction that is not unique";
    BELT_WAY = "S024", "a belt without a way around its wheels";
    ANGLE_JUMPS = "S025", "an angle that jumps at half a turn";
    AT_DEAD_CENTRE = "S028", "at rest in a dead centre";
    RATE_JUMPS = "S029", "a drive whose rate jumps";
    POSITIONS_ALONE = "S030", "positions alone can be asked for";
    DRIVE_CANNOT_PASS = "R001", "a drive cannot pass a dead centre";
    NO_VALUE = "R002", "an expression leaves its domain";
    STEP_TOO_SMALL = "R003", "the step size became too small";
    TOO_MANY_STEPS = "R004", "too many steps";
    SINGULAR = "R005", "a singular pose";
    CHATTER = "R006", "a switch thrown forth and back";
    NO_CONTACTS = "R007", "contacts that exclude each other";
    DRIVE_JUMPS = "R008", "a drive that jumps";
    TOO_LARGE = "R009", "numbers that grow beyond all bounds";
    ENERGY_OFF = "R010", "a balance of energy that does not close";
    DRIFTED = "R011", "constraints that are not kept";
    SLOW = "R012", "far more steps than expected";
    ANGLE_POLE = "R013", "angles at their pole";
    TABLE_LEFT = "R014", "a table is left";
    NO_SIGNAL = "R015", "a sampled signal without a value";
    JAMS = "R016", "a joint that jams while it moves";
    ENDLESS = "R017", "latched signals that change without end";
    BELOW_NOISE = "R018", "a tolerance below the noise of the accelerations";
    ANOTHER_ASSEMBLY = "R019", "another assembly than the one that is held";
    FRICTION_DRIVES = "R020", "friction that drives while it slides";
}
