// Joints and links of the live page: a click on one edits it, a drag moves a pin.
//
// `page` is what the modules of the page share:
//   root, at(selector)        the element of the page; an element in it
//   send(kind, request)       a reply of the server, see server.py
//   state                     start, controls (a Map by path), values, view, phase, scene (the reply of "picture")
//   apply(values, controls)   set all values at once, as one step of undo; controls are added, and their rows shown
//   change(values)            set some values, as one step of undo; valueOf(path) is the present one
//   show(path)                show the row of a control
//   note(text), complain(text), make(tag, attributes, ...children), button(text, action, title), select(options, chosen)
// Events on the root: "shown" after a new view, "drawn" after a new picture, "counted" after a new table, "row" for a new row of a control, with
// {row, control} as its detail. The picture is the only svg in ".picture"; ".tools" is for buttons of further actions.

export function joints(page) {
}
