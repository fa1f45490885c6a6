;;; bksim.lsp: bodies, joints and drives attached from inside the editor, as extended data.
;;;
;;; Load it with APPLOAD in AutoCAD, BricsCAD and their kin. Commands:
;;;   BKBODY    an entity becomes (geometry of) a body
;;;   BKJOINT   a joint at a point of an entity
;;;   BKDRIVE   a prescribed motion of a joint
;;;   BKDEL     what is attached to an entity is removed
;;;   BKLIST    what is attached to an entity is listed
;;;   BKCMP     areas, centres of mass, inertias: `bksim cad mass`
;;;   BKSOLVE   the motion: `bksim solve`
;;; The program `bksim` must be on the path. No test runs this file: it is only checked to be balanced.

;; All values of an entity under our name, the records one after another.
(defun bk:values (ent / found)
  (setq found (assoc -3 (entget ent '("BKSIM"))))
  (if found (cdr (cadr found)) nil))

;; Replaces all values of an entity under our name; none removes them.
(defun bk:store (ent values)
  (regapp "BKSIM")
  (entmod
    (list (cons -1 ent)
          (list -3 (cons "BKSIM" values)))))

;; Adds a record: kind { entries }.
(defun bk:add (ent kind entries)
  (bk:store ent
    (append (bk:values ent)
            (list (cons 1000 kind) (cons 1002 "{"))
            entries
            (list (cons 1002 "}")))))

;; key=value, or nothing for an empty value.
(defun bk:entry (key value)
  (if (or (null value) (= value ""))
    nil
    (list (cons 1000 (strcat key "=" value)))))

;; A place: moves with the entity. A direction: turns with it.
(defun bk:place (key point)
  (list (cons 1000 key) (cons 1011 (trans point 1 0))))

(defun bk:axis (from to)
  (list (cons 1000 "axis")
        (cons 1013 (mapcar '- (trans to 1 0) (trans from 1 0)))))

(defun bk:ask (question) (getstring T (strcat "\n" question ": ")))

(defun bk:pick (question / picked)
  (setq picked (entsel (strcat "\n" question ": ")))
  (if picked (car picked) nil))

(defun c:BKBODY (/ ent)
  (if (setq ent (bk:pick "Outline of the body"))
    (bk:add ent "body"
      (append (bk:entry "name" (bk:ask "Name"))
              (bk:entry "mass" (bk:ask "Mass, e.g. 2 kg <of the outline>"))
              (bk:entry "inertia" (bk:ask "Moment of inertia <of the outline>"))
              (bk:entry "density" (bk:ask "Density, e.g. 7850 kg/m^3 <none>"))
              (bk:entry "thickness" (bk:ask "Thickness, e.g. 10 mm <none>")))))
  (princ))

(defun c:BKJOINT (/ ent kind at to)
  (initget "Revolute Prismatic Slot Weld")
  (setq kind (getkword "\nKind [Revolute/Prismatic/Slot/Weld] <Revolute>: "))
  (if (null kind) (setq kind "Revolute"))
  (setq ent (bk:pick "Entity that carries the joint"))
  (setq at (getpoint "\nPlace of the joint: "))
  (if (and at (or (= kind "Prismatic") (= kind "Slot")))
    (setq to (getpoint at "\nDirection: ")))
  (if (and ent at)
    (bk:add ent (strcase kind T)
      (append (bk:entry "name" (bk:ask "Name"))
              (bk:entry "body1" (bk:ask "First body, or ground <by geometry>"))
              (bk:entry "body2" (bk:ask "Second body <by geometry>"))
              (bk:place "at" at)
              (if to (bk:axis at to) nil))))
  (princ))

(defun c:BKDRIVE (/ ent)
  (if (setq ent (bk:pick "Entity that carries the drive"))
    (bk:add ent "drive"
      (append (bk:entry "name" (bk:ask "Name"))
              (bk:entry "joint" (bk:ask "Joint"))
              (bk:entry "motion" (bk:ask "Motion, e.g. 60 rpm*t")))))
  (princ))

(defun c:BKDEL (/ ent)
  (if (setq ent (bk:pick "Entity to free of what is attached"))
    (bk:store ent nil))
  (princ))

(defun c:BKLIST (/ ent)
  (if (setq ent (bk:pick "Entity"))
    (foreach value (bk:values ent)
      (princ "\n  ")
      (princ (cdr value))))
  (princ))

;; The saved file; a drawing in DWG is read as well.
(defun bk:file () (strcat (getvar "DWGPREFIX") (getvar "DWGNAME")))

;; Runs bksim in a window that stays open.
(defun bk:run (arguments)
  (command "_.QSAVE")
  (startapp "cmd.exe" (strcat "/k bksim " arguments " \"" (bk:file) "\""))
  (princ))

(defun c:BKCMP () (bk:run "cad mass"))

(defun c:BKSOLVE () (bk:run "solve"))

(princ "\nbksim: BKBODY BKJOINT BKDRIVE BKDEL BKLIST BKCMP BKSOLVE")
(princ)
