; Members of an ensemble in the lanes of vectors, with @@names@@ filled in by lane_stepper.py
;
; %queue holds the number of the next member, that of the first one that may not begin yet, and whether to stop
; (any thread may change them). Member n starts from row n of %states with row n of %parameters. Its result goes to row n
; of %results: the state, then the time, and as integers the numbers of steps and samples; then %ended[n] becomes 1 + the
; reason. (Members that did not reach their end, or were not confirmed, are left to @advance.) Its samples go to part n
; modulo %slots of %samples.
;
; A pack of lanes is unchanged between calls. @follow returns when it is told to stop, or when all its lanes are empty and no
; member may begin.

; Load the next member into a lane; false if there is none.
define internal i1 @admit(ptr %pack, i64 %lane, ptr %parameters, ptr %states, ptr %queue, double %start) #1 {
entry:
  %limita = getelementptr inbounds i64, ptr %queue, i64 1
  %seen = load atomic i64, ptr %queue monotonic, align 8
  br label %take
take:
  %n = phi i64 [ %seen, %entry ], [ %found, %try ]
  %limit = load atomic i64, ptr %limita acquire, align 8
  %any = icmp ult i64 %n, %limit
  br i1 %any, label %try, label %none
none:
  ret i1 false
try:
  %n1 = add i64 %n, 1
  %pair = cmpxchg ptr %queue, i64 %n, i64 %n1 monotonic monotonic
  %found = extractvalue { i64, i1 } %pair, 0
  %mine = extractvalue { i64, i1 } %pair, 1
  br i1 %mine, label %load, label %take
load:
  %column = getelementptr inbounds double, ptr %pack, i64 %lane
  %scratch = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_scratch@@
  %own = mul i64 %n, @@parameters@@
  %values = getelementptr inbounds double, ptr %parameters, i64 %own
  call void @prepare_lane(ptr %values, ptr %scratch)
  %constants = getelementptr inbounds @@real@@, ptr %column, i64 @@at_constants@@
  call void @spread(ptr %scratch, ptr %constants, i64 @@constants@@)
  %from = mul i64 %n, @@rows@@
  %state = getelementptr inbounds double, ptr %states, i64 %from
  call void @spread(ptr %state, ptr %column, i64 @@rows@@)
  br label %low
low:
  %i = phi i64 [ @@at_low@@, %load ], [ %i1, %low ]
  %la = getelementptr inbounds @@real@@, ptr %column, i64 %i
  store double 0.0, ptr %la, align 8
  %i1 = add i64 %i, 1
  %more = icmp ule i64 %i1, @@at_reached@@
  br i1 %more, label %low, label %rest
rest:
  %ta = getelementptr inbounds @@real@@, ptr %column, i64 @@at_time@@
  store double %start, ptr %ta, align 8
  %ma = getelementptr inbounds @@real@@, ptr %column, i64 @@at_member@@
  store i64 %n, ptr %ma, align 8
  ret i1 true
}

; %to[8 i] = %from[i]
define internal void @spread(ptr %from, ptr %to, i64 %count) #1 {
entry:
  br label %test
test:
  %i = phi i64 [ 0, %entry ], [ %i1, %copy ]
  %more = icmp ult i64 %i, %count
  br i1 %more, label %copy, label %done
copy:
  %fa = getelementptr inbounds double, ptr %from, i64 %i
  %x = load double, ptr %fa, align 8
  %ta = getelementptr inbounds @@real@@, ptr %to, i64 %i
  store double %x, ptr %ta, align 8
  %i1 = add i64 %i, 1
  br label %test
done:
  ret void
}

; Store the result of a lane's member.
define internal void @retire(ptr %pack, i64 %lane, i64 %code, ptr %results, ptr %ended) #1 {
entry:
  %column = getelementptr inbounds double, ptr %pack, i64 %lane
  %ma = getelementptr inbounds @@real@@, ptr %column, i64 @@at_member@@
  %n = load i64, ptr %ma, align 8
  %from = mul i64 %n, @@numbers@@
  %row = getelementptr inbounds double, ptr %results, i64 %from
  br label %copy
copy:
  %i = phi i64 [ 0, %entry ], [ %i1, %copy ]
  %ca = getelementptr inbounds @@real@@, ptr %column, i64 %i
  %x = load double, ptr %ca, align 8
  %ra = getelementptr inbounds double, ptr %row, i64 %i
  store double %x, ptr %ra, align 8
  %i1 = add i64 %i, 1
  %more = icmp ult i64 %i1, @@rows@@
  br i1 %more, label %copy, label %rest
rest:
  %ta = getelementptr inbounds @@real@@, ptr %column, i64 @@at_time@@
  %t = load double, ptr %ta, align 8
  %sa = getelementptr inbounds @@real@@, ptr %column, i64 @@at_steps@@
  %steps = load i64, ptr %sa, align 8
  %na = getelementptr inbounds @@real@@, ptr %column, i64 @@at_reached@@
  %reached = load i64, ptr %na, align 8
  %r0 = getelementptr inbounds double, ptr %row, i64 @@rows@@
  %r1 = getelementptr inbounds double, ptr %r0, i64 1
  %r2 = getelementptr inbounds double, ptr %r0, i64 2
  store double %t, ptr %r0, align 8
  store i64 %steps, ptr %r1, align 8
  store i64 %reached, ptr %r2, align 8
  %mark = trunc i64 %code to i8
  %mark1 = add i8 %mark, 1
  %ea = getelementptr inbounds i8, ptr %ended, i64 %n
  store atomic i8 %mark1, ptr %ea release, align 1
  ret void
}

; Sample the lanes in %mask at the time %dt of the step: rows of %trial, then column by column.
define internal void @record(ptr %pack, @@real@@ %dt, <@@lanes@@ x i1> %mask, i64 %count, i64 %slots, ptr %samples) #1 {
entry:
  %work = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_work@@
  %trial = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_trial@@
  call void @lane_sample(ptr %pack, ptr %work, @@real@@ %dt, ptr %trial)
  %bits = bitcast <@@lanes@@ x i1> %mask to i8
  %wide = zext i8 %bits to i64
  br label %next
next:
  %left = phi i64 [ %wide, %entry ], [ %left1, %stored ]
  %lane = call i64 @llvm.cttz.i64(i64 %left, i1 true)
  %below = sub i64 %left, 1
  %left1 = and i64 %left, %below
  %column = getelementptr inbounds double, ptr %pack, i64 %lane
  %ma = getelementptr inbounds @@real@@, ptr %column, i64 @@at_member@@
  %n = load i64, ptr %ma, align 8
  %slot = urem i64 %n, %slots
  %first = mul i64 %slot, @@rows@@
  %na = getelementptr inbounds @@real@@, ptr %column, i64 @@at_reached@@
  %reached = load i64, ptr %na, align 8
  %reached1 = add i64 %reached, 1
  store i64 %reached1, ptr %na, align 8
  %tcolumn = getelementptr inbounds double, ptr %trial, i64 %lane
  br label %copy
copy:
  %i = phi i64 [ 0, %next ], [ %i1, %copy ]
  %xa = getelementptr inbounds @@real@@, ptr %tcolumn, i64 %i
  %x = load double, ptr %xa, align 8
  %row = add i64 %first, %i
  %place = mul i64 %row, %count
  %place1 = add i64 %place, %reached
  %oa = getelementptr inbounds double, ptr %samples, i64 %place1
  store double %x, ptr %oa, align 8
  %i1 = add i64 %i, 1
  %more = icmp ult i64 %i1, @@rows@@
  br i1 %more, label %copy, label %stored
stored:
  %any = icmp ne i64 %left1, 0
  br i1 %any, label %next, label %done
done:
  ret void
}

; The time of each lane's next sample within the step; nan if there is none.
define internal @@real@@ @ahead(ptr %pack, ptr %times, i64 %count) #1 {
entry:
  br label %lane
lane:
  %l = phi i64 [ 0, %entry ], [ %l1, %known ]
  %v = phi @@real@@ [ poison, %entry ], [ %v1, %known ]
  %column = getelementptr inbounds double, ptr %pack, i64 %l
  %na = getelementptr inbounds @@real@@, ptr %column, i64 @@at_reached@@
  %reached = load i64, ptr %na, align 8
  %any = icmp ult i64 %reached, %count
  br i1 %any, label %read, label %known
read:
  %sa = getelementptr inbounds double, ptr %times, i64 %reached
  %s = load double, ptr %sa, align 8
  br label %known
known:
  %x = phi double [ 0x7FF8000000000000, %lane ], [ %s, %read ]
  %v1 = insertelement @@real@@ %v, double %x, i64 %l
  %l1 = add i64 %l, 1
  %more = icmp ult i64 %l1, @@lanes@@
  br i1 %more, label %lane, label %done
done:
  %ta = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_time@@
  %t = load @@real@@, ptr %ta, align 64
  %tla = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_time_low@@
  %tl = load @@real@@, ptr %tla, align 64
  %d = fsub @@real@@ %v1, %t
  %dt = fsub @@real@@ %d, %tl
  ret @@real@@ %dt
}

define void @follow(ptr noalias %pack, ptr noalias %parameters, ptr noalias %states, ptr %queue, double %start, double %stop, ptr noalias %times, i64 %count, ptr noalias %results, ptr noalias %ended, ptr noalias %samples, i64 %slots) #1 {
entry:
  %ta = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_time@@
  %tla = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_time_low@@
  %hpa = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_previous@@
  %stepsa = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_steps@@
  %activea = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_active@@
  %constants = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_constants@@
  %finishinga = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_finishing@@
  %work = getelementptr inbounds @@real@@, ptr %pack, i64 @@at_work@@
  %halta = getelementptr inbounds i64, ptr %queue, i64 2
  %limita = getelementptr inbounds i64, ptr %queue, i64 1
  %s1 = insertelement @@real@@ poison, double %stop, i64 0
  %stops = shufflevector @@real@@ %s1, @@real@@ poison, <@@lanes@@ x i32> zeroinitializer
  br label %step
step:
  %halt = load atomic i64, ptr %halta monotonic, align 8
  %halted = icmp ne i64 %halt, 0
  br i1 %halted, label %return, label %look
look:
  %active0 = load i64, ptr %activea, align 8
  %empty = xor i64 %active0, @@all@@
  %some = icmp ne i64 %empty, 0
  br i1 %some, label %refill, label %expand
refill:
  %left = phi i64 [ %empty, %look ], [ %left1, %admitted ]
  %active = phi i64 [ %active0, %look ], [ %active2, %admitted ]
  %lane = call i64 @llvm.cttz.i64(i64 %left, i1 true)
  %below = sub i64 %left, 1
  %left1 = and i64 %left, %below
  %got = call i1 @admit(ptr %pack, i64 %lane, ptr %parameters, ptr %states, ptr %queue, double %start)
  %bit = shl i64 1, %lane
  %active1 = or i64 %active, %bit
  %active2 = select i1 %got, i64 %active1, i64 %active
  br label %admitted
admitted:
  %again0 = icmp ne i64 %left1, 0
  %again = and i1 %again0, %got
  br i1 %again, label %refill, label %filled
filled:
  store i64 %active2, ptr %activea, align 8
  %idle = icmp eq i64 %active2, 0
  br i1 %idle, label %return, label %expand
expand:
  %now = phi i64 [ %active0, %look ], [ %active2, %filled ]
  %now8 = trunc i64 %now to i8
  %live = bitcast i8 %now8 to <@@lanes@@ x i1>
  %t = load @@real@@, ptr %ta, align 64
  %tl = load @@real@@, ptr %tla, align 64
  %hp = load @@real@@, ptr %hpa, align 64
  %tn = fadd @@real@@ %t, %tl
  %regular = call <@@lanes@@ x i1> @paired_jet(ptr %constants, @@real@@ %tn, ptr %pack, ptr %work)
  %left_n = fsub @@real@@ %stops, %tn
  %begun = load <@@lanes@@ x i64>, ptr %stepsa, align 64
  %moved = icmp ne <@@lanes@@ x i64> %begun, zeroinitializer
  %foretold = call <@@lanes@@ x i1> @lane_foretold(ptr %pack, ptr %work)
  %sound = and <@@lanes@@ x i1> %foretold, %regular
  %unsound = xor <@@lanes@@ x i1> %sound, @@true@@
  %refused0 = and <@@lanes@@ x i1> %unsound, %moved
  %refused = and <@@lanes@@ x i1> %refused0, %live
  %finishing64 = load i64, ptr %finishinga, align 8
  %finishing8 = trunc i64 %finishing64 to i8
  %finishing = bitcast i8 %finishing8 to <@@lanes@@ x i1>
  %isfirst = fcmp oeq @@real@@ %hp, zeroinitializer
  %over = select <@@lanes@@ x i1> %isfirst, @@real@@ @@one@@, @@real@@ %hp
  %hm = call { @@real@@, @@real@@ } @lane_length(ptr %pack, ptr %work, @@real@@ %over)
  %hu = extractvalue { @@real@@, @@real@@ } %hm, 0
  %met = extractvalue { @@real@@, @@real@@ } %hm, 1
  %four = fmul @@real@@ %over, @@four@@
  %leaps = fcmp ogt @@real@@ %hu, %four
  %unsure0 = or <@@lanes@@ x i1> %leaps, %isfirst
  %unsure = and <@@lanes@@ x i1> %unsure0, %live
  %unsure8 = bitcast <@@lanes@@ x i1> %unsure to i8
  %anyunsure = icmp ne i8 %unsure8, 0
  br i1 %anyunsure, label %careful, label %chosen
careful:
  %big = fcmp olt @@real@@ %hu, @@largest@@
  %g1 = select <@@lanes@@ x i1> %big, @@real@@ %hu, @@real@@ @@largest@@
  %hm2 = call { @@real@@, @@real@@ } @lane_length(ptr %pack, ptr %work, @@real@@ %g1)
  %g2 = extractvalue { @@real@@, @@real@@ } %hm2, 0
  %big2 = fcmp olt @@real@@ %g2, @@largest@@
  %g3 = select <@@lanes@@ x i1> %big2, @@real@@ %g2, @@real@@ @@largest@@
  %guess = select <@@lanes@@ x i1> %isfirst, @@real@@ %g3, @@real@@ %hp
  %hc0 = call @@real@@ @lane_cautious(ptr %pack, ptr %work, @@real@@ %guess)
  br label %vetted
vetted:
  %hv = select <@@lanes@@ x i1> %unsure, @@real@@ %hc0, @@real@@ %hu
  br label %chosen
chosen:
  %h = phi @@real@@ [ %hu, %expand ], [ %hv, %vetted ]
  %finite = fcmp olt @@real@@ %met, @@infinity@@
  %ts = call @@real@@ @llvm.fabs.v@@lanes@@f64(@@real@@ %tn)
  %ulp = fmul @@real@@ %ts, @@ulp@@
  %floor = fadd @@real@@ %ulp, @@least@@
  %tiny = fcmp ole @@real@@ %h, %floor
  %short = fcmp olt @@real@@ %h, %left_n
  %stuck = and <@@lanes@@ x i1> %tiny, %short
  %go0 = and <@@lanes@@ x i1> %live, %regular
  %go1 = and <@@lanes@@ x i1> %go0, %finite
  %unstuck = xor <@@lanes@@ x i1> %stuck, @@true@@
  %go2 = and <@@lanes@@ x i1> %go1, %unstuck
  %halting = or <@@lanes@@ x i1> %finishing, %refused
  %going = xor <@@lanes@@ x i1> %halting, @@true@@
  %moving = and <@@lanes@@ x i1> %go2, %going
  %final0 = fcmp ole @@real@@ %left_n, %h
  %final = and <@@lanes@@ x i1> %final0, %moving
  %l1 = fsub @@real@@ %stops, %t
  %l2 = fsub @@real@@ %l1, %tl
  %hs0 = select <@@lanes@@ x i1> %final, @@real@@ %l2, @@real@@ %h
  %hs = select <@@lanes@@ x i1> %moving, @@real@@ %hs0, @@real@@ zeroinitializer
  br label %sampling
sampling:
  %wanted = icmp ne i64 %count, 0
  br i1 %wanted, label %sample, label %update
sample:
  %dt = call @@real@@ @ahead(ptr %pack, ptr %times, i64 %count)
  %inside = fcmp ole @@real@@ %dt, %hs
  %due = and <@@lanes@@ x i1> %inside, %moving
  %due8 = bitcast <@@lanes@@ x i1> %due to i8
  %anydue = icmp ne i8 %due8, 0
  br i1 %anydue, label %write, label %update
write:
  call void @record(ptr %pack, @@real@@ %dt, <@@lanes@@ x i1> %due, i64 %count, i64 %slots, ptr %samples)
  br label %sample
update:
  call void @lane_update(ptr %pack, ptr %work, @@real@@ %hs, <@@lanes@@ x i1> %moving)
  %hn = select <@@lanes@@ x i1> %moving, @@real@@ %h, @@real@@ %hp
  store @@real@@ %hn, ptr %hpa, align 64
  %taken = zext <@@lanes@@ x i1> %moving to <@@lanes@@ x i64>
  %steps = load <@@lanes@@ x i64>, ptr %stepsa, align 64
  %steps1 = add <@@lanes@@ x i64> %steps, %taken
  store <@@lanes@@ x i64> %steps1, ptr %stepsa, align 64
  %final8 = bitcast <@@lanes@@ x i1> %final to i8
  %final64 = zext i8 %final8 to i64
  store i64 %final64, ptr %finishinga, align 8
  %stopped = xor <@@lanes@@ x i1> %moving, @@true@@
  %done = and <@@lanes@@ x i1> %stopped, %live
  %done8 = bitcast <@@lanes@@ x i1> %done to i8
  %anydone = icmp ne i8 %done8, 0
  br i1 %anydone, label %ending, label %step
ending:
  %refused8 = bitcast <@@lanes@@ x i1> %refused to i8
  %unrefused8 = xor i8 %refused8, -1
  %ended8 = and i8 %finishing8, %unrefused8
  br label %each
each:
  %rest = phi i8 [ %done8, %ending ], [ %rest1, %each ]
  %low = call i8 @llvm.cttz.i8(i8 %rest, i1 true)
  %before = sub i8 %rest, 1
  %rest1 = and i8 %rest, %before
  %ending_lane = zext i8 %low to i64
  %single = shl i8 1, %low
  %f1 = and i8 %ended8, %single
  %isfinal = icmp ne i8 %f1, 0
  %c3 = select i1 %isfinal, i64 @@end@@, i64 @@pause@@
  call void @retire(ptr %pack, i64 %ending_lane, i64 %c3, ptr %results, ptr %ended)
  %more = icmp ne i8 %rest1, 0
  br i1 %more, label %each, label %emptied
emptied:
  %doneint = zext i8 %done8 to i64
  %keep = xor i64 %doneint, @@all@@
  %remaining = and i64 %now, %keep
  store i64 %remaining, ptr %activea, align 8
  br label %step
return:
  ret void
}
