(* Read the table, the class and the claims by lp-dual of a certificate, as docs/certificate.md and
   docs/certificate-worst-case.md describe them.  What is not as described is malformed; the rest of a
   certificate is left to fairaudit/checker. *)

module W = Worst_case

let malformed where what = raise (Json.Malformed (where ^ " " ^ what))
let member where i = Printf.sprintf "%s[%d]" where i
let mapi_where f where items = List.mapi (fun i item -> f item (member where i)) items

(* ---- Types of JSON ---- *)

let fields ?(optional = []) keys (value : Json.t) where =
  match value with
  | Json.Object members ->
      List.iter (fun key -> if not (List.mem_assoc key members) then malformed where ("lacks the key " ^ key)) keys;
      List.iter
        (fun (key, _) -> if not (List.mem key keys || List.mem key optional) then malformed where "has a key that is not in the format")
        members;
      members
  | _ -> malformed where "must be an object"

let get members key = List.assoc key members
let has members key = List.mem_assoc key members

let list ?length (value : Json.t) where =
  match value with
  | Json.List items ->
      (match length with
       | Some n when List.length items <> n -> malformed where (Printf.sprintf "must have %d entries" n)
       | _ -> items)
  | _ -> malformed where "must be a list"

let has_surrogate s =
  let n = String.length s in
  let rec go i = i + 1 < n && ((s.[i] = '\xED' && s.[i + 1] >= '\xA0') || go (i + 1)) in
  go 0

let text (value : Json.t) where =
  match value with
  | Json.String s -> if has_surrogate s then malformed where "holds a lone surrogate" else s
  | _ -> malformed where "must be a string"

let texts ?length value where = mapi_where text where (list ?length value where)

let one_of choices value where =
  let s = text value where in
  if List.mem s choices then s else malformed where ("must be one of " ^ String.concat ", " choices)

let index ?below (value : Json.t) where =
  match value with
  | Json.Int n when n >= 0 && (match below with Some b -> n < b | None -> true) -> n
  | _ -> malformed where "must be an integer in range"

let boolean (value : Json.t) where = match value with Json.Bool b -> b | _ -> malformed where "must be true or false"

let nullable read (value : Json.t) where = match value with Json.Null -> None | _ -> Some (read value where)

let check_distinct items where =
  if items = [] then malformed where "must not be empty";
  if List.length (List.sort_uniq compare items) <> List.length items then malformed where "lists something twice"

(* ---- Rationals ---- *)

let longest = 100_000

(* The digits from [i] on: where they end, and their value; no needless zero. *)
let digits s i where =
  let n = String.length s in
  let rec stop j = if j < n && s.[j] >= '0' && s.[j] <= '9' then stop (j + 1) else j in
  let j = stop i in
  if j = i || (s.[i] = '0' && j > i + 1) then malformed where "must be a rational, a string like \"3/2\" or \"3\"";
  if j - i > longest then malformed where "has too many digits";
  (j, Z.of_string (String.sub s i (j - i)))

let rational ?(nonnegative = false) (value : Json.t) where : W.q =
  match value with
  | Json.String s ->
      let n = String.length s in
      let negative = n > 0 && s.[0] = '-' in
      let j, above = digits s (if negative then 1 else 0) where in
      let below =
        if j = n then Z.one
        else if s.[j] <> '/' then malformed where "must be a rational, a string like \"3/2\" or \"3\""
        else begin
          let k, d = digits s (j + 1) where in
          if k < n || Z.leq d Z.one || not (Z.equal (Z.gcd above d) Z.one) then malformed where "must be a rational in lowest terms";
          d
        end
      in
      if negative && (Z.equal above Z.zero || nonnegative) then malformed where "must not have that sign";
      { W.qnum = (if negative then Z.neg above else above); qden = below }
  | _ -> malformed where "must be a rational, a string like \"3/2\" or \"3\""

let extended (value : Json.t) where = if value = Json.String "inf" then None else Some (rational value where)

let rationals ?nonnegative ?length value where = mapi_where (fun item place -> rational ?nonnegative item place) where (list ?length value where)

let number (q : W.q) = Q.make q.W.qnum q.W.qden
let sum qs = List.fold_left (fun total q -> Q.add total (number q)) Q.zero qs
let zero : W.q = { W.qnum = Z.zero; qden = Z.one }

(* ---- The table ---- *)

type header = {
  kind : string;
  population : string;
  decisions : string list;
  groups : int;
  contexts : int;
  utility : W.q list option;
}

type row = { context : int; group : int; weights : W.q list; mass : W.q; gains : W.q list }

let about members where =
  let kind = one_of [ "counts"; "probabilities" ] (get members "kind") (where ^ ".kind") in
  let populations = if kind = "counts" then [ "counts" ] else [ "weights"; "equal" ] in
  let population = one_of populations (get members "population") (where ^ ".population") in
  let place = where ^ ".columns" in
  let columns = fields [ "decision"; "group"; "context" ] (get members "columns") place in
  let decision = text (get columns "decision") place in
  let group = texts (get columns "group") place and context = texts (get columns "context") place in
  if group = [] then malformed place "must name at least one column of groups";
  check_distinct ((decision :: group) @ context) place;
  (kind, population, List.length group, List.length context)

let header value =
  let where = "the header of the table" in
  let keys = [ "format"; "kind"; "columns"; "population"; "decisions"; "groups"; "contexts"; "utility" ] in
  let members = fields ~optional:[ "salt" ] keys value where in
  ignore (one_of [ "fairaudit-table/1" ] (get members "format") where);
  if has members "salt" then begin
    let salt = text (get members "salt") where in
    let hexadecimal c = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F') in
    if String.length salt <> 32 || not (String.for_all hexadecimal salt) then malformed where "has a salt that is not 32 hexadecimal digits"
  end;
  let kind, population, group_width, context_width = about members where in
  let decisions = texts (get members "decisions") (where ^ ".decisions") in
  check_distinct decisions (where ^ ".decisions");
  let labels key width =
    let place = where ^ "." ^ key in
    let lists = mapi_where (fun item place -> texts ~length:width item place) place (list (get members key) place) in
    check_distinct lists place;
    List.length lists
  in
  let groups = labels "groups" group_width in
  let contexts = labels "contexts" context_width in
  let read = rationals ~nonnegative:true ~length:(List.length decisions) in
  { kind; population; decisions; groups; contexts; utility = nullable read (get members "utility") (where ^ ".utility") }

let row header value where =
  let given = (if header.population = "weights" then [ "mass" ] else []) @ if header.utility = None then [ "utility" ] else [] in
  let members = fields ([ "context"; "group"; "weights" ] @ given) value where in
  let n = List.length header.decisions in
  let weights = rationals ~nonnegative:true ~length:n (get members "weights") (where ^ ".weights") in
  let total = sum weights in
  if Q.equal total Q.zero then malformed where "has weights that are all zero";
  if header.kind <> "counts" && not (Q.equal total Q.one) then malformed where "has probabilities that do not sum to 1";
  let gain weight item place =
    match item with
    | Json.Null when Z.equal weight.W.qnum Z.zero -> zero
    | Json.Null -> malformed place "is null where the weight is positive"
    | _ -> rational ~nonnegative:true item place
  in
  let gains =
    match header.utility with
    | Some utility -> utility
    | None ->
        let place = where ^ ".utility" in
        let items = list ~length:n (get members "utility") place in
        List.mapi (fun i (weight, item) -> gain weight item (member place i)) (List.combine weights items)
  in
  {
    context = index ~below:header.contexts (get members "context") (where ^ ".context");
    group = index ~below:header.groups (get members "group") (where ^ ".group");
    weights;
    mass = (if has members "mass" then rational ~nonnegative:true (get members "mass") (where ^ ".mass") else zero);
    gains;
  }

let rec check_sorted = function
  | r :: (s :: _ as rest) ->
      if (s.context, s.group) <= (r.context, r.group) then malformed "the table" "is not in increasing order of context and group";
      check_sorted rest
  | _ -> ()

let table first rest =
  let header = header first in
  let rows = List.mapi (fun i item -> row header item (Printf.sprintf "row %d of the table" i)) rest in
  check_sorted rows;
  if header.utility = None && rows = [] then malformed "the table" "gives no utility at all";
  if header.population = "weights" && not (Q.equal (sum (List.map (fun r -> r.mass) rows)) Q.one) then
    malformed "the table" "has masses that do not sum to 1";
  (header, rows)

(* ---- The class ---- *)

type constraint_term = { x : int; a : int option; u : int; c : W.q }

type family = { names : int; lower : W.q list; upper : W.q list; features : W.q list list list; family_rows : (W.q list * W.q) list }

type utilities = {
  quantity : string;
  gamma : W.q;
  least : W.q;
  tau : W.q option;
  on_pair : bool;
  blind : bool;
  lipschitz : W.q option;
  metric : W.q list list option;
  order : (string * string) list;
  rows : (constraint_term list * W.q) list;
  family : family option;
}

let distances value where =
  let n = List.length (list value where) in
  let rows = mapi_where (fun item place -> rationals ~nonnegative:true ~length:n item place) where (list value where) in
  let d = Array.of_list (List.map (fun row -> Array.of_list (List.map number row)) rows) in
  for i = 0 to n - 1 do
    for j = 0 to n - 1 do
      if Q.equal d.(i).(j) Q.zero <> (i = j) then malformed where "must be zero on the diagonal and positive elsewhere";
      if not (Q.equal d.(i).(j) d.(j).(i)) then malformed where "must be symmetric";
      for k = 0 to n - 1 do
        if Q.gt d.(i).(j) (Q.add d.(i).(k) d.(k).(j)) then malformed where "violates the triangle inequality"
      done
    done
  done;
  rows

let constraint_term blind value where =
  match list ~length:4 value where with
  | [ context; group; decision; coefficient ] ->
      if blind && group <> Json.Null then malformed where "must name no group, since the class is blind";
      {
        x = index context where;
        a = (if blind then None else Some (index group where));
        u = index decision where;
        c = rational coefficient where;
      }
  | _ -> malformed where "must have 4 entries"

let constraint_row blind value where =
  let members = fields [ "terms"; "bound" ] value where in
  let place = where ^ ".terms" in
  (mapi_where (constraint_term blind) place (list (get members "terms") place), rational (get members "bound") (where ^ ".bound"))

let family value where =
  let members = fields [ "names"; "lower"; "upper"; "features"; "rows" ] value where in
  let names = texts (get members "names") (where ^ ".names") in
  check_distinct names (where ^ ".names");
  let n = List.length names in
  let lower = rationals ~length:n (get members "lower") (where ^ ".lower") in
  let upper = rationals ~length:n (get members "upper") (where ^ ".upper") in
  List.iter2 (fun low high -> if Q.gt (number low) (number high) then malformed where "has a lower end above the upper end") lower upper;
  let place = where ^ ".features" in
  let of_cell item place = mapi_where (fun phi place -> rationals ~length:n phi place) place (list item place) in
  let features = mapi_where of_cell place (list (get members "features") place) in
  let family_row item place =
    let row = fields [ "coefficients"; "bound" ] item place in
    (rationals ~length:n (get row "coefficients") place, rational (get row "bound") place)
  in
  let place = where ^ ".rows" in
  { names = n; lower; upper; features; family_rows = mapi_where family_row place (list (get members "rows") place) }

let utilities value =
  let where = "subject.class" in
  let keys = [ "quantity"; "gamma"; "m"; "tau"; "tau_on"; "blind"; "lipschitz"; "metric"; "order"; "rows"; "family" ] in
  let members = fields keys value where in
  let at key = where ^ "." ^ key in
  let nonnegative value where = rational ~nonnegative:true value where in
  let blind = boolean (get members "blind") (at "blind") in
  let gamma = nonnegative (get members "gamma") (at "gamma") in
  let least = nonnegative (get members "m") (at "m") in
  let tau = nullable nonnegative (get members "tau") (at "tau") in
  let lipschitz = nullable nonnegative (get members "lipschitz") (at "lipschitz") in
  let above q = Q.gt (number q) (number gamma) in
  if Z.equal gamma.W.qnum Z.zero || above least then malformed (at "gamma") "must be positive and at least m";
  (match tau with Some t when above t -> malformed (at "tau") "must be at most gamma" | _ -> ());
  if blind && lipschitz <> None then malformed (at "lipschitz") "must be null when the class is blind";
  let pair item place = match texts ~length:2 item place with [ low; high ] -> (low, high) | _ -> malformed place "must have 2 entries" in
  {
    quantity = one_of [ "local"; "global" ] (get members "quantity") (at "quantity");
    gamma;
    least;
    tau;
    on_pair = one_of [ "pair"; "all" ] (get members "tau_on") (at "tau_on") = "pair";
    blind;
    lipschitz;
    metric = nullable distances (get members "metric") (at "metric");
    order = mapi_where pair (at "order") (list (get members "order") (at "order"));
    rows = mapi_where (constraint_row blind) (at "rows") (list (get members "rows") (at "rows"));
    family = nullable family (get members "family") (at "family");
  }

(* ---- Claims ---- *)

type claim = {
  number : int;
  quantity : string;
  shown : string;
  known : bool;  (* a claim of the format about every utility of the class *)
  value : W.q option;
  evidence : W.evidence list;
}

let multipliers value where =
  let one item place =
    match list ~length:2 item place with
    | [ number; y ] ->
        let y = rational ~nonnegative:true y place in
        if Z.equal y.W.qnum Z.zero then malformed place "must be positive";
        (index number place, y)
    | _ -> malformed place "must have 2 entries"
  in
  let found = mapi_where one where (list value where) in
  let rec check = function
    | (i, _) :: ((j, _) :: _ as rest) -> if j <= i then malformed where "has numbers that do not increase"; check rest
    | _ -> ()
  in
  check found;
  List.map (fun (i, y) -> (Z.of_int i, y)) found

let pairs about_local parameters value where =
  let members = fields ("pairs" :: (match parameters with Some _ -> [ "theta" ] | None -> [])) value where in
  let one item place =
    let entry = fields ((if about_local then [ "context" ] else []) @ [ "higher"; "lower"; "multipliers" ]) item place in
    let context = if about_local then index (get entry "context") place else -1 in
    let higher = index (get entry "higher") place and lower = index (get entry "lower") place in
    ((context, higher, lower), multipliers (get entry "multipliers") (place ^ ".multipliers"))
  in
  let place = where ^ ".pairs" in
  let found = mapi_where one place (list (get members "pairs") place) in
  let rec check = function
    | (p, _) :: ((q, _) :: _ as rest) -> if q <= p then malformed place "is not in increasing order"; check rest
    | _ -> ()
  in
  check found;
  Option.iter (fun n -> ignore (rationals ~length:n (get members "theta") (where ^ ".theta"))) parameters;
  let evidence ((x, h, l), ys) =
    { W.at_context = Z.of_int x; higher = Z.of_int h; lower_group = Z.of_int l; multipliers = ys }
  in
  List.map evidence found

let claim parameters number value where =
  let members = fields [ "quantity"; "relation"; "value"; "scope"; "by"; "assumptions"; "evidence" ] value where in
  let part key = text (get members key) (where ^ "." ^ key) in
  let quantity = part "quantity" and relation = part "relation" and scope = part "scope" and by = part "by" in
  let value = extended (get members "value") (where ^ ".value") in
  ignore (texts (get members "assumptions") (where ^ ".assumptions"));
  if by <> "lp-dual" then None
  else begin
    let known = List.mem quantity [ "local_ratio"; "global_ratio" ] && relation = "<=" && scope = "every utility of the class" in
    let place = where ^ ".evidence" in
    let evidence =
      match get members "evidence" with
      | given when known -> pairs (quantity = "local_ratio") parameters given place
      | Json.Object _ -> []
      | _ -> malformed place "must be an object"
    in
    let written q = if Z.equal q.W.qden Z.one then Z.to_string q.W.qnum else Z.to_string q.W.qnum ^ "/" ^ Z.to_string q.W.qden in
    let shown = Printf.sprintf "claims[%d]: the ratio is at most %s" number (match value with None -> "inf" | Some q -> written q) in
    Some { number; quantity; shown; known; value; evidence }
  end

(* ---- What the verified checker is given ---- *)

let numbers n = List.init n Z.of_int

let position label labels =
  let rec go i = function [] -> None | l :: rest -> if String.equal l label then Some i else go (i + 1) rest in
  go 0 labels

let for_kernel (k : utilities) (header, rows) : W.utilities * W.table =
  let where = "subject.class" in
  let n = List.length header.decisions in
  (match k.metric with
   | Some rows when List.length rows <> header.groups -> malformed (where ^ ".metric") "must have one row for each group"
   | _ -> ());
  let decision label =
    match position label header.decisions with
    | Some u -> Z.of_int u
    | None -> malformed (where ^ ".order") "names a decision that the table does not have"
  in
  let present = Hashtbl.create 64 in
  List.iter (fun (r : row) -> Hashtbl.replace present (r.context, if k.blind then None else Some r.group) ()) rows;
  let term t : W.term =
    if not (Hashtbl.mem present (t.x, t.a)) || t.u >= n then malformed (where ^ ".rows") "names what the table does not have";
    {
      W.of_context = Z.of_int t.x;
      of_group = Z.of_int (Option.value t.a ~default:(-1));
      of_decision = Z.of_int t.u;
      coefficient = t.c;
    }
  in
  let features =
    match k.family with
    | None -> List.map (fun _ -> List.map (fun _ -> []) header.decisions) rows
    | Some f ->
        let place = where ^ ".family.features" in
        if List.length f.features <> List.length rows then malformed place "must have one entry for each cell";
        List.iter (fun cell -> if List.length cell <> n then malformed place "must have one list for each decision") f.features;
        f.features
  in
  if k.blind then begin
    let first = Hashtbl.create 64 in
    let alike (r : row) phi =
      match Hashtbl.find_opt first r.context with
      | None -> Hashtbl.add first r.context phi
      | Some other -> if other <> phi then malformed (where ^ ".family.features") "differ between groups, but the class is blind"
    in
    List.iter2 alike rows features
  end;
  let outcome u ((weight, stated), features) = { W.decision = Z.of_int u; weight; features; stated } in
  let cell (r : row) phi =
    {
      W.context = Z.of_int r.context;
      group = Z.of_int r.group;
      outcomes = List.mapi outcome (List.combine (List.combine r.weights r.gains) phi);
      weight_of_cell = r.mass;
    }
  in
  let population = match header.population with "counts" -> W.Counted | "weights" -> W.Given | _ -> W.Alike in
  let table = { W.contexts = numbers header.contexts; groups = numbers header.groups; population; cells = List.map2 cell rows features } in
  let of_family f = { W.lower = f.lower; upper = f.upper; family_rows = f.family_rows } in
  ( {
      W.local = k.quantity = "local";
      gamma = k.gamma;
      least = k.least;
      tau = k.tau;
      on_pair = k.on_pair;
      blind = k.blind;
      lipschitz = k.lipschitz;
      metric = k.metric;
      order = List.map (fun (low, high) -> (decision low, decision high)) k.order;
      rows = List.map (fun (terms, bound) -> (List.map term terms, bound)) k.rows;
      parameters = Option.map of_family k.family;
    },
    table )

(* ---- The certificate ---- *)

exception Table_needed

(* The claims by lp-dual, each with whether it is proved. *)
let judged (document : Json.t) (lines : Json.t list option) : (claim * bool) list =
  let keys = [ "format"; "subject"; "metrics"; "not_compared"; "claims"; "targets"; "verdict"; "versions" ] in
  let top = fields ~optional:[ "intervals" ] keys document "the certificate" in
  ignore (one_of [ "fairaudit-certificate/1" ] (get top "format") "format");
  let subject = match get top "subject" with Json.Object members -> members | _ -> malformed "subject" "must be an object" in
  let of_policy = List.assoc_opt "kind" subject = Some (Json.String "policy") in
  let further = if of_policy then [ "privacy"; "declared" ] else [] in
  let optional = if of_policy then [] else [ "class" ] in
  let subject = fields ~optional ([ "kind"; "columns"; "population"; "table"; "utility" ] @ further) (get top "subject") "subject" in
  let k = if has subject "class" then Some (utilities (get subject "class")) else None in
  if not of_policy then ignore (about subject "subject");
  if k <> None && has top "intervals" then malformed "the certificate" "has intervals besides a class of utilities";
  let parameters = Option.bind k (fun k -> Option.map (fun f -> f.names) k.family) in
  let items = list (get top "claims") "claims" in
  let claims = List.filter_map Fun.id (List.mapi (fun i item -> claim parameters i item (member "claims" i)) items) in
  let given = fields ~optional:[ "header"; "rows" ] [ "sha256"; "cells" ] (get subject "table") "subject.table" in
  let table_of k =
    let first, rest =
      if has given "header" || has given "rows" then begin
        let given = fields [ "sha256"; "cells"; "header"; "rows" ] (get subject "table") "subject.table" in
        (get given "header", list (get given "rows") "subject.table.rows")
      end
      else match lines with None -> raise Table_needed | Some [] -> malformed "the table" "is empty" | Some (first :: rest) -> (first, rest)
    in
    for_kernel k (table first rest)
  in
  let checks = Option.map table_of k in
  let seen = Hashtbl.create 2 in
  let judge c =
    let repeated = Hashtbl.mem seen c.quantity in
    if c.known then Hashtbl.add seen c.quantity ();
    let proved =
      c.known && (not repeated)
      && match checks with None -> false | Some (k, t) -> W.claim_true k t (c.quantity = "local_ratio") c.value c.evidence
    in
    (c, proved)
  in
  List.map judge claims
