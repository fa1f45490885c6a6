;;; bksim.lsp: everything that can be attached, from inside the editor, as extended data.
;;;
;;; Load it with APPLOAD in AutoCAD, BricsCAD and their kin. Commands:
;;;   BKBODY BKREVOLUTE BKSPRING ...   one for each kind of docs/drawings.md; BKSETUP is `solve`
;;;   BKADD     asks for the kind
;;;   BKEDIT    changes what is attached to an entity
;;;   BKDEL     removes it, one record or all
;;;   BKLIST    lists it
;;;   BKMARK    draws a marker at everything that is attached, anew; BKUNMARK removes the markers
;;;   BKCMP     areas, centres of mass, inertias: `bksim cad mass`
;;;   BKDOCTOR  what is wrong with the drawing: `bksim cad doctor`
;;;   BKSOLVE   the motion: `bksim solve`
;;; The program `bksim` must be on the path. Each command is one step of U; one that is cancelled
;;; leaves the drawing as it was. What has the same kind and name on one entity is changed, not doubled.

;; Kind, its place (a point, a point and a direction, two points, or none), and its keys.
(setq bk:kinds
  '(
    ("ground" point "name")
    ("body" point "name" "mass" "inertia" "about" "density" "thickness" "free" "coordinates")
    ("point" point "name" "body")
    ("com" point "body")
    ("frame" frame "body")
    ("revolute" point "name" "body1" "body2" "point1" "point2" "coordinate" "cut" "angle" "rate"
      "bodies")
    ("prismatic" frame "name" "body1" "body2" "point1" "point2" "coordinate" "cut" "position"
      "velocity")
    ("slot" frame "name" "body1" "body2" "point1" "point2" "coordinate" "cut" "position"
      "velocity" "angle" "rate")
    ("weld" point "name" "body1" "body2" "point1" "point2" "cut")
    ("link" line "name" "body1" "body2" "point1" "point2" "length")
    ("point-on-curve" line "name" "body1" "body2" "point1" "point2" "curve" "radius" "side"
      "coordinate")
    ("line-on-curve" line "name" "body1" "body2" "point1" "point2" "curve" "axis" "direction"
      "coordinate")
    ("curve-on-curve" line "name" "body1" "body2" "point1" "point2" "curve" "second_curve"
      "tangents" "rolling" "coordinate")
    ("cylinder" line "name" "body1" "body2" "point1" "point2" "min" "max" "restitution"
      "coordinate")
    ("gravity" frame "name" "acceleration")
    ("force" frame "name" "body" "point" "value" "vector" "axes" "joint" "of")
    ("actuator" line "name" "body1" "body2" "point1" "point2" "value")
    ("torque" point "name" "body" "from" "joint" "of" "value")
    ("spring" line "name" "body1" "body2" "point1" "point2" "stiffness" "length" "damping" "joint"
      "of")
    ("damper" line "name" "body1" "body2" "point1" "point2" "damping" "joint" "of")
    ("torsion" point "name" "joint" "of" "stiffness" "angle" "damping")
    ("stop" point "name" "joint" "of" "min" "max" "restitution")
    ("friction" point "name" "joint" "of" "force" "torque" "mu" "static" "radius" "length"
      "coupling" "pressure_angle" "loss")
    ("drive" point "name" "joint" "of" "motion")
    ("gear" line "name" "between" "teeth" "module" "radii" "ratio" "internal" "carrier" "phase")
    ("rack" line "name" "between" "teeth" "module" "radius" "reversed" "phase")
    ("belt" line "name" "between" "teeth" "module" "radii" "crossed" "carrier" "phase" "turns"
      "length" "stiffness" "damping")
    ("chain" line "name" "between" "teeth" "module" "radii" "carrier" "phase" "turns" "length"
      "stiffness" "damping")
    ("screw" point "name" "between" "lead" "phase")
    ("relation" nil "name" "relation")
    ("table" nil "name" "points" "file" "units" "interpolation" "extrapolate")
    ("curve" nil "name" "points" "formula" "parameter" "range")
    ("cam-law" nil "name" "segments" "turns")
    ("cam" nil "name" "law" "base_circle" "follower" "sense")
    ("state" nil "name" "rate" "start")
    ("clock" nil "name" "every" "start")
    ("signal" nil "name" "value" "clock" "start" "when")
    ("part" nil "name" "part" "file" "on" "with")
    ("parameter" nil "name" "value")
    ("initial" nil "name" "x" "y" "angle" "angle1" "angle2" "position" "vx" "vy" "rate"
      "rate1" "rate2" "velocity" "value" "guess")
    ("solve" nil "t_start" "t_end" "every" "times" "rtol" "atol" "step" "newton_tolerance"
      "method" "formulation" "jit")
    ("io" nil "input" "output")
    ("model" nil "name" "coordinates" "length" "mass" "time" "angle" "force")
   ))

;; Kinds of which an entity has one, whatever its name.
(setq bk:single '("body" "ground" "com" "frame" "solve" "io" "model"))

;; Markers stand on this layer; texts on it mean nothing.
(setq bk:marks "BK_MARKS")

;;; Records: kind, then items; an item is its key, then its groups.

;; All values of an entity under our name, one record after another.
(defun bk:values (ent / found)
  (setq found (assoc -3 (entget ent '("BKSIM"))))
  (if found (cdr (cadr found)) nil))

;; Replaces all values of an entity under our name; none removes them.
(defun bk:store (ent values)
  (regapp "BKSIM")
  (entmod (append (entget ent) (list (list -3 (cons "BKSIM" values))))))

;; The part of a text before its first =, or all of it.
(defun bk:key (text / at)
  (setq at 1)
  (while (and (<= at (strlen text)) (/= (substr text at 1) "=")) (setq at (1+ at)))
  (substr text 1 (1- at)))

;; The part of a text after its first =.
(defun bk:after (text)
  (substr text (+ 2 (strlen (bk:key text)))))

;; The items of the values between the braces of a record.
(defun bk:items (groups / out group)
  (while groups
    (setq group (car groups)
          groups (cdr groups))
    (if (= (bk:key (cdr group)) (cdr group))
      (setq out (cons (list (cdr group) group (car groups)) out)
            groups (cdr groups))
      (setq out (cons (list (bk:key (cdr group)) group) out))))
  (reverse out))

;; The records of all values of an entity.
(defun bk:records (values / out kind groups inside)
  (foreach value values
    (cond
      ((and (= (car value) 1002) (= (cdr value) "{"))
       (setq inside T groups nil))
      ((= (car value) 1002)
       (setq out (cons (cons kind (bk:items (reverse groups))) out)
             inside nil))
      (inside (setq groups (cons value groups)))
      (T (setq kind (cdr value)))))
  (reverse out))

;; The values of records.
(defun bk:flat (records)
  (apply 'append
    (mapcar
      '(lambda (record)
         (append (list (cons 1000 (car record)) (cons 1002 "{"))
                 (apply 'append (mapcar 'cdr (cdr record)))
                 (list (cons 1002 "}"))))
      records)))

;; The text that a record states for a key; nil where it states none, or a number.
(defun bk:text (record key / item)
  (setq item (assoc key (cdr record)))
  (if (and item (null (cddr item))) (bk:after (cdr (cadr item))) nil))

;; The record with the groups of a key replaced; no groups remove the key.
(defun bk:put (record key groups / out done)
  (foreach item (cdr record)
    (if (= (car item) key)
      (if (and groups (not done)) (setq out (cons (cons key groups) out) done T))
      (setq out (cons item out))))
  (if (and groups (not done)) (setq out (cons (cons key groups) out)))
  (cons (car record) (reverse out)))

;; Whether two records say the same thing of one entity.
(defun bk:same (a b / key)
  (setq key (caddr (assoc (car a) bk:kinds)))
  (and (= (car a) (car b))
       (or (member (car a) bk:single)
           (= (bk:text a key) (bk:text b key)))))

;; The records with one put in the place of that which says the same, or at the end.
(defun bk:merge (records new / out done)
  (foreach record records
    (if (and (not done) (bk:same record new))
      (setq out (cons new out) done T)
      (setq out (cons record out))))
  (if (not done) (setq out (cons new out)))
  (reverse out))

;;; Questions.

(defun bk:pick (question / picked)
  (setq picked (entsel (strcat "\n" question ": ")))
  (if picked (car picked) nil))

;; A text; Enter keeps the known one, a point removes it.
(defun bk:ask (key known / answer)
  (setq answer (getstring T (strcat "\n" key (if known (strcat " <" known ", . for none>") "") ": ")))
  (cond
    ((= answer "") known)
    ((= answer ".") nil)
    (T answer)))

;; key=value as groups, or nothing.
(defun bk:entry (key value)
  (if (or (null value) (= value "")) nil (list (cons 1000 (strcat key "=" value)))))

;; A place moves with the entity, a direction turns with it.
(defun bk:place (key point) (list (cons 1000 key) (cons 1011 (trans point 1 0))))
(defun bk:axis (from to)
  (list (cons 1000 "axis") (cons 1013 (mapcar '- (trans to 1 0) (trans from 1 0)))))

;; The record with its place as it is picked; Enter keeps what is there.
(defun bk:placed (record place / at to)
  (if place
    (progn
      (setq at (getpoint "\nPlace, or Enter for that of the entity: "))
      (if (and at (/= place 'point))
        (setq to (getpoint at (if (= place 'line) "\nSecond point: " "\nDirection: "))))
      (if at (setq record (bk:put record "at" (bk:place "at" at))))
      (if (and to (= place 'line)) (setq record (bk:put record "to" (bk:place "to" to))))
      (if (and to (= place 'frame)) (setq record (bk:put record "axis" (bk:axis at to))))))
  record)

;; The record with what is answered for its keys, from the given one on.
(defun bk:asked (record keys / known)
  (foreach key keys
    (setq known (bk:text record key))
    ;; A number of another program stays unless a text is given for it.
    (if (or known (null (assoc key (cdr record))))
      (setq record (bk:put record key (bk:entry key (bk:ask key known))))))
  record)

;;; Steps of U, and errors.

(defun bk:begin () (setvar "CMDECHO" 0) (command "_.UNDO" "_Begin"))
(defun bk:end () (command "_.UNDO" "_End"))

;; What an error leaves is taken back; cancelling needs no word.
(defun bk:failed (message)
  (command)
  (bk:end)
  (command "_.U")
  (if (not (member message '("Function cancelled" "quit / exit abort")))
    (princ (strcat "\nbksim: " message)))
  (princ))

;;; Attaching, editing, removing.

(defun bk:attach (kind / *error* row ent record known)
  (defun *error* (message) (bk:failed message))
  (bk:begin)
  (setq row (assoc kind bk:kinds))
  (if (setq ent (bk:pick (strcat "Entity that carries the " kind)))
    (progn
      (setq record (bk:asked (list kind) (list (caddr row))))
      ;; What is there already is changed.
      (foreach other (bk:records (bk:values ent))
        (if (and (not known) (bk:same other record)) (setq known other)))
      (if known (setq record (bk:put known (caddr row) (cdr (assoc (caddr row) (cdr record))))))
      (bk:write ent record row)))
  (bk:end)
  (princ))

;; Asks for the rest of a record and stores it.
(defun bk:write (ent record row)
  (setq record (bk:asked record (cdddr row)))
  (if (/= (car row) "body") (setq record (bk:placed record (cadr row))))
  (bk:store ent (bk:flat (bk:merge (bk:records (bk:values ent)) record)))
  (bk:mark record))

;; One of the records of an entity by its number; the only one without a question.
(defun bk:chosen (records question / number)
  (if (cdr records)
    (progn
      (setq number 0)
      (foreach record records
        (setq number (1+ number))
        (princ (strcat "\n  " (itoa number) " " (bk:title record))))
      (setq number (getint (strcat "\n" question ": ")))
      (if number (nth (1- number) records) nil))
    (car records)))

;; Kind and name.
(defun bk:title (record / name)
  (setq name (bk:text record (caddr (assoc (car record) bk:kinds))))
  (if name (strcat (car record) " " name) (car record)))

(defun c:BKADD (/ kind)
  (setq kind (strcase (getstring (strcat "\nKind: ")) T))
  (if (assoc kind bk:kinds)
    (bk:attach kind)
    (progn
      (princ (strcat "\nbksim: `" kind "` is no kind; kinds are"))
      (foreach row bk:kinds (princ (strcat " " (car row))))
      (princ))))

(defun c:BKEDIT (/ *error* ent record row new)
  (defun *error* (message) (bk:failed message))
  (bk:begin)
  (if (setq ent (bk:pick "Entity to edit"))
    (if (setq record (bk:chosen (bk:records (bk:values ent)) "Number of what is to be edited"))
      (progn
        (setq row (assoc (car record) bk:kinds))
        (setq new (bk:asked record (list (caddr row))))
        ;; Under another name it is still the same record.
        (bk:store ent (bk:flat (subst new record (bk:records (bk:values ent)))))
        (bk:write ent new row))
      (princ "\nbksim: nothing is attached to it")))
  (bk:end)
  (princ))

(defun c:BKDEL (/ *error* ent records record left)
  (defun *error* (message) (bk:failed message))
  (bk:begin)
  (if (setq ent (bk:pick "Entity to free of what is attached"))
    (progn
      (setq records (bk:records (bk:values ent))
            record (bk:chosen records "Number of what is to be removed, or Enter for all"))
      (if record
        (foreach other records (if (not (equal other record)) (setq left (append left (list other))))))
      (bk:store ent (bk:flat left))))
  (bk:end)
  (princ))

(defun c:BKLIST (/ ent)
  (if (setq ent (bk:pick "Entity"))
    (foreach record (bk:records (bk:values ent))
      (princ (strcat "\n" (bk:title record)))
      (foreach item (cdr record)
        (princ "\n  ")
        (princ (cdr (cadr item)))
        (if (cddr item) (progn (princ " ") (princ (cdr (caddr item))))))))
  (princ))

;;; Markers.

;; The point of a record, if it states one.
(defun bk:point (record / item)
  (setq item (assoc "at" (cdr record)))
  (if (and item (cddr item)) (cdr (caddr item)) nil))

;; A text with kind and name where a record says that it is.
(defun bk:mark (record / at)
  (if (setq at (bk:point record))
    (entmake
      (list (cons 0 "TEXT") (cons 8 bk:marks) (cons 10 at) (cons 40 (getvar "TEXTSIZE"))
            (cons 1 (bk:title record))))))

(defun bk:unmark (/ set number)
  (setq set (ssget "_X" (list (cons 0 "TEXT") (cons 8 bk:marks)))
        number 0)
  (if set
    (while (< number (sslength set))
      (entdel (ssname set number))
      (setq number (1+ number)))))

(defun c:BKUNMARK (/ *error*)
  (defun *error* (message) (bk:failed message))
  (bk:begin)
  (bk:unmark)
  (bk:end)
  (princ))

(defun c:BKMARK (/ *error* set number)
  (defun *error* (message) (bk:failed message))
  (bk:begin)
  (bk:unmark)
  (setq set (ssget "_X" '((-3 ("BKSIM"))))
        number 0)
  (if set
    (while (< number (sslength set))
      (foreach record (bk:records (bk:values (ssname set number))) (bk:mark record))
      (setq number (1+ number))))
  (bk:end)
  (princ))

;;; The program.

;; The saved file; a drawing in DWG is read as well.
(defun bk:file () (strcat (getvar "DWGPREFIX") (getvar "DWGNAME")))

;; Runs bksim in a window that stays open.
(defun bk:run (arguments)
  (command "_.QSAVE")
  (startapp "cmd.exe" (strcat "/k bksim " arguments " \"" (bk:file) "\""))
  (princ))

(defun c:BKCMP () (bk:run "cad mass"))
(defun c:BKDOCTOR () (bk:run "cad doctor"))
(defun c:BKSOLVE () (bk:run "solve"))

;;; One command for each kind.

(defun c:BKGROUND () (bk:attach "ground"))
(defun c:BKBODY () (bk:attach "body"))
(defun c:BKPOINT () (bk:attach "point"))
(defun c:BKCOM () (bk:attach "com"))
(defun c:BKFRAME () (bk:attach "frame"))
(defun c:BKREVOLUTE () (bk:attach "revolute"))
(defun c:BKPRISMATIC () (bk:attach "prismatic"))
(defun c:BKSLOT () (bk:attach "slot"))
(defun c:BKWELD () (bk:attach "weld"))
(defun c:BKLINK () (bk:attach "link"))
(defun c:BKGRAVITY () (bk:attach "gravity"))
(defun c:BKFORCE () (bk:attach "force"))
(defun c:BKACTUATOR () (bk:attach "actuator"))
(defun c:BKTORQUE () (bk:attach "torque"))
(defun c:BKSPRING () (bk:attach "spring"))
(defun c:BKDAMPER () (bk:attach "damper"))
(defun c:BKTORSION () (bk:attach "torsion"))
(defun c:BKSTOP () (bk:attach "stop"))
(defun c:BKFRICTION () (bk:attach "friction"))
(defun c:BKDRIVE () (bk:attach "drive"))
(defun c:BKPOINT-ON-CURVE () (bk:attach "point-on-curve"))
(defun c:BKLINE-ON-CURVE () (bk:attach "line-on-curve"))
(defun c:BKCURVE-ON-CURVE () (bk:attach "curve-on-curve"))
(defun c:BKCYLINDER () (bk:attach "cylinder"))
(defun c:BKGEAR () (bk:attach "gear"))
(defun c:BKRACK () (bk:attach "rack"))
(defun c:BKBELT () (bk:attach "belt"))
(defun c:BKCHAIN () (bk:attach "chain"))
(defun c:BKSCREW () (bk:attach "screw"))
(defun c:BKRELATION () (bk:attach "relation"))
(defun c:BKTABLE () (bk:attach "table"))
(defun c:BKCURVE () (bk:attach "curve"))
(defun c:BKCAM-LAW () (bk:attach "cam-law"))
(defun c:BKCAM () (bk:attach "cam"))
(defun c:BKSTATE () (bk:attach "state"))
(defun c:BKCLOCK () (bk:attach "clock"))
(defun c:BKSIGNAL () (bk:attach "signal"))
(defun c:BKPART () (bk:attach "part"))
(defun c:BKIO () (bk:attach "io"))
(defun c:BKPARAMETER () (bk:attach "parameter"))
(defun c:BKINITIAL () (bk:attach "initial"))
(defun c:BKSETUP () (bk:attach "solve"))
(defun c:BKMODEL () (bk:attach "model"))

(princ "\nbksim: BKADD BKEDIT BKDEL BKLIST BKMARK BKUNMARK BKCMP BKDOCTOR BKSOLVE, and one command a kind")
(princ)
