//! Codes of the faults of files that are imported, one row each; the page is what `bksim explain` prints.

bksim_model::codes! {
    UNKNOWN_FORMAT = "I001", "a file that is not imported";
    NOT_XML = "I002", "the file is not XML";
    MISSING = "I003", "something is missing";
    NOT_A_NUMBER = "I004", "numbers that cannot be read";
    UNKNOWN_NAME = "I005", "a name that is not in the file";
    NO_FILE = "I006", "a file that is not there";
    CIRCLE = "I007", "parts that follow from each other";
    IMPOSSIBLE_INERTIA = "I008", "an inertia that no body has";
    UNKNOWN_WORD = "I009", "a word that the format does not have";
    NOT_MODELLED = "I010", "a joint that cannot be modelled";
    TWICE = "I011", "a name that is used twice";
    BAD_LINK = "I012", "a link of PMKS+ that cannot be read";
    BAD_STATEMENT = "I013", "a statement that cannot be read";
    NO_BODIES = "I014", "nothing to import";
    TOO_LARGE = "I015", "a file that is too large";
    NO_MECHANISM = "I016", "a drawing without joints";
    TOO_MANY_STROKES = "I017", "a drawing with too many strokes";
    NO_QUESTION = "I018", "an answer to no question";
    NO_ANSWER = "I019", "an answer that no question has";
    NOT_ATTACHED = "I020", "a drawing that cannot hold its model";
    NOT_HELD = "I024", "a model that the format cannot hold";
    OPEN_LOOP = "I025", "a loop that the file leaves open";
    REFUSED_BODY = "I026", "a body that robot programs refuse";
    STRAIGHTENED = "I027", "axes that are made parallel";
}
