; The stepping loop in double-double, with @@names@@ filled in by advance_double_double.py; compare stepper.ll.
define internal void @clear(ptr %place, i64 %count) #0 {
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %at = getelementptr inbounds double, ptr %place, i64 %i
  store <8 x double> zeroinitializer, ptr %at, align 64
  %next = add nuw nsw i64 %i, 8
  %more = icmp ult i64 %next, %count
  br i1 %more, label %loop, label %done
done:
  ret void
}

; %to = %from, whole states
define internal void @copy(ptr noalias %from, ptr noalias %to) #0 {
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %fa = getelementptr inbounds double, ptr %from, i64 %i
  %x = load <2 x double>, ptr %fa, align 8
  %ta = getelementptr inbounds double, ptr %to, i64 %i
  store <2 x double> %x, ptr %ta, align 8
  %next = add nuw nsw i64 %i, 2
  %more = icmp ult i64 %next, @@memory@@
  br i1 %more, label %loop, label %done
done:
  ret void
}

define i64 @accelerate(ptr %constants, double %t, ptr %state, ptr %work, ptr %rates) #0 {
  %regular = call i1 @jet(ptr %constants, double %t, double 0.0, double 1.0, ptr %state, ptr %work)
  call void @rates(ptr %work, ptr %rates)
  %code = zext i1 %regular to i64
  ret i64 %code
}

; The clock: t, its low part, the last step, the distance to a critical point, the usual step (the pace), the number of steps
; that narrowly failed confirmation, the time when a critical point was last passed, how many times it was passed at nearly
; the same t; then %doubt, %far, %lax of the step from here, so that another call takes the same step.
define i64 @advance(ptr %constants, ptr %state, ptr %work, ptr %trial, double %stop, ptr %times, i64 %count, ptr %out, i64 %stride, i64 %last, i64 %pause, ptr %info) #0 {
entry:
  %tpa = getelementptr inbounds double, ptr %state, i64 @@time@@
  %tla = getelementptr inbounds double, ptr %tpa, i64 1
  %hpa = getelementptr inbounds double, ptr %tpa, i64 2
  %gapa = getelementptr inbounds double, ptr %tpa, i64 3
  %pacea = getelementptr inbounds double, ptr %tpa, i64 4
  %milda = getelementptr inbounds double, ptr %tpa, i64 5
  %lasta = getelementptr inbounds double, ptr %tpa, i64 6
  %timesa = getelementptr inbounds double, ptr %tpa, i64 7
  %doubta = getelementptr inbounds double, ptr %tpa, i64 8
  %fara = getelementptr inbounds double, ptr %tpa, i64 9
  %laxa = getelementptr inbounds double, ptr %tpa, i64 10
  %expected = getelementptr inbounds double, ptr %trial, i64 @@memory@@
  %stepsa = getelementptr inbounds i64, ptr %info, i64 1
  %beyond = mul i64 %stride, @@rows@@
  %doubt_kept = load double, ptr %doubta, align 8
  %doubt_begin = fcmp ogt double %doubt_kept, 0.0
  %far_kept = load double, ptr %fara, align 8
  %far_begin = fcmp ogt double %far_kept, 0.0
  %lax_kept = load double, ptr %laxa, align 8
  %lax_begin = fcmp ogt double %lax_kept, 0.0
  br label %step
; %pending: what to return when the last step is confirmed (-1: go on, -2: there is nothing to confirm). The step began at
; sample %from, had the length %length, and passed a critical point if %blind. %refused: ever shorter steps from here were not
; confirmed; %far: nor was a step over the critical point; %lax: and the cause is not known.
step:
  %index = phi i64 [ 0, %entry ], [ %at, %advanced ], [ %from, %again ]
  %taken = phi i64 [ 0, %entry ], [ %taken1, %advanced ], [ %less, %again ]
  %pending = phi i64 [ -2, %entry ], [ %pending1, %advanced ], [ -2, %again ]
  %from = phi i64 [ 0, %entry ], [ %index, %advanced ], [ %from, %again ]
  %length = phi double [ 0.0, %entry ], [ %hs, %advanced ], [ 0.0, %again ]
  %blind = phi i1 [ false, %entry ], [ %over, %advanced ], [ false, %again ]
  %refused = phi i1 [ %doubt_begin, %entry ], [ %doubt, %advanced ], [ %refused_next, %again ]
  %far = phi i1 [ %far_begin, %entry ], [ false, %advanced ], [ %blind, %again ]
  %lax = phi i1 [ %lax_begin, %entry ], [ %lax_now, %advanced ], [ %lax, %again ]
  %t = load double, ptr %tpa, align 8
  %tl = load double, ptr %tla, align 8
  %hp = load double, ptr %hpa, align 8
  %isfirst = fcmp oeq double %hp, 0.0
  %bits = bitcast double %hp to i64
  %exponent = and i64 %bits, 9218868437227405312
  %power = bitcast i64 %exponent to double
  %scale0 = select i1 %isfirst, double 1.0, double %power
  %regular = call i1 @jet(ptr %constants, double %t, double %tl, double %scale0, ptr %state, ptr %work)
  %inverse0 = fdiv double 1.0, %scale0
  %unchecked = icmp eq i64 %pending, -2
  br i1 %unchecked, label %checked, label %check
check:
  %squared = fmul double %length, %length
  %room = fdiv double @@nothing_much@@, %squared
  %mild_ones = load double, ptr %milda, align 8
  %isnoisy = fcmp oge double %mild_ones, @@evidence@@
  %slack = select i1 %isnoisy, double @@noisy@@, double 1.0
  %foretold = call i1 @foretold(ptr %work, ptr %expected, double %inverse0, i1 %lax, double %room, double %slack)
  %good = and i1 %foretold, %regular
  br i1 %good, label %confirmed, label %refuse
; There is a critical point within the step that the series does not show. Go back and take at most half the step; or, if the
; equations were singular just beyond the point, go twice as far.
refuse:
  %usual_step = load double, ptr %pacea, align 8
  %much = fmul double %usual_step, @@widest@@
  %isfar = fcmp ogt double %length, %much
  %hopeless = and i1 %isfar, %blind
  br i1 %hopeless, label %wall, label %back
back:
  %mild = call i1 @foretold(ptr %work, ptr %expected, double %inverse0, i1 false, double %room, double @@noisy@@)
  call void @copy(ptr %trial, ptr %state)
  br label %again
again:
  %less = sub i64 %taken, 1
  %gap_before = load double, ptr %gapa, align 8
  %pace_before = load double, ptr %pacea, align 8
  %begins = fcmp oeq double %gap_before, 0.0
  %refused_next = or i1 %refused, %begins
  %twice = fmul double %length, 2.0
  %bound = select i1 %blind, double %twice, double %length
  store double %bound, ptr %gapa, align 8
  %pace_then = select i1 %begins, double %usual_step, double %pace_before
  store double %pace_then, ptr %pacea, align 8
  %quarter = fmul double %usual_step, 0.25
  %usually = fcmp ogt double %length, %quarter
  %ismild0 = and i1 %mild, %begins
  %ismild1 = and i1 %ismild0, %usually
  %ismild = and i1 %ismild1, %regular
  %one_more = uitofp i1 %ismild to double
  %mild_now = fadd double %mild_ones, %one_more
  store double %mild_now, ptr %milda, align 8
  br label %step
; The critical point cannot be passed. The run ends at the last state where the equations hold, or at the first one where
; they are not finite.
wall:
  %huge = call i1 @foretold(ptr %work, ptr %expected, double %inverse0, i1 true, double 0x7FEFFFFFFFFFFFFF, double 1.0)
  %nonumber = xor i1 %huge, true
  %outside = and i1 %nonumber, %regular
  br i1 %outside, label %return, label %inside
inside:
  call void @copy(ptr %trial, ptr %state)
  %less1 = sub i64 %taken, 1
  %cause = select i1 %regular, i64 @@underflow@@, i64 @@singular@@
  br label %return
confirmed:
  switch i64 %pending, label %checked [ i64 @@end@@, label %return
                                        i64 @@samples@@, label %many ]
; The step contains more samples than there is room for. It is completed after they are written.
many:
  call void @copy(ptr %trial, ptr %state)
  %without = sub i64 %taken, 1
  br label %return
checked:
  %doubt = phi i1 [ %refused, %step ], [ false, %confirmed ]
  %lax_still = phi i1 [ %lax, %step ], [ false, %confirmed ]
  %doubt_here = uitofp i1 %doubt to double
  store double %doubt_here, ptr %doubta, align 8
  %far_here = uitofp i1 %far to double
  store double %far_here, ptr %fara, align 8
  %lax_here = uitofp i1 %lax_still to double
  store double %lax_here, ptr %laxa, align 8
  %enough = icmp uge i64 %taken, %pause
  br i1 %enough, label %return, label %expanded
expanded:
  br i1 %regular, label %measure, label %return
; The coefficients were scaled by the last step. They are computed again if they overflow, or if most of them vanish.
measure:
  %scale = phi double [ %scale0, %expanded ], [ %smaller, %shrink ], [ %larger, %stretch ]
  %stretched = phi i1 [ false, %expanded ], [ true, %shrink ], [ true, %stretch ]
  %inverse = fdiv double 1.0, %scale
  br i1 %isfirst, label %first, label %usual
first:
  %g0 = call double @length(ptr %state, ptr %work, double 1.0)
  %g1 = call double @length(ptr %state, ptr %work, double %g0)
  br label %sized
usual:
  %hp_scaled = fmul double %hp, %inverse
  %hu = call double @length(ptr %state, ptr %work, double %hp_scaled)
  br label %sized
sized:
  %scaled = phi double [ %g1, %first ], [ %hu, %usual ]
  %h_any = fmul double %scaled, %scale
  %h_guess = call double @llvm.minnum.f64(double %h_any, double @@longest@@)
  %finite = fcmp ord double %scaled, 0.0
  br i1 %finite, label %fits, label %narrow
narrow:
  %vast = fcmp ogt double %scale, @@narrowest@@
  br i1 %vast, label %shrink, label %return
shrink:
  %smaller = fmul double %scale, @@narrower@@
  call i1 @jet(ptr %constants, double %t, double %tl, double %smaller, ptr %state, ptr %work)
  br label %measure
fits:
  %iswide = fcmp ogt double %scaled, @@wide@@
  %isbound = fcmp olt double %h_any, @@longest@@
  %wide0 = and i1 %iswide, %isbound
  %fresh = xor i1 %stretched, true
  %stretches = and i1 %wide0, %fresh
  br i1 %stretches, label %stretch, label %choose
stretch:
  %h_bits = bitcast double %h_any to i64
  %h_exponent = and i64 %h_bits, 9218868437227405312
  %larger = bitcast i64 %h_exponent to double
  call i1 @jet(ptr %constants, double %t, double %tl, double %larger, ptr %state, ptr %work)
  br label %measure
choose:
  %gap = load double, ptr %gapa, align 8
  %nogap = fcmp oeq double %gap, 0.0
  %leap = fmul double %hp, 4.0
  %isleap0 = fcmp ogt double %h_guess, %leap
  %isleap = and i1 %isleap0, %nogap
  br i1 %isleap, label %vet, label %long
vet:
  %hc = phi double [ %h_guess, %choose ], [ %shorter, %reject ]
  %tries = phi i64 [ 0, %choose ], [ %tries1, %reject ]
  %left0 = fsub double %stop, %t
  %needed = call double @llvm.minnum.f64(double %hc, double %left0)
  %sound = call i1 @holds(ptr %constants, ptr %state, ptr %work, double %needed, double %scale, ptr %trial)
  %tired = icmp ugt i64 %tries, 30
  %accept = or i1 %sound, %tired
  br i1 %accept, label %long, label %reject
reject:
  %shorter = fmul double %needed, 0.25
  %tries1 = add i64 %tries, 1
  br label %vet
long:
  %h = phi double [ %h_guess, %choose ], [ %hc, %vet ]
  %ts = call double @llvm.fabs.f64(double %t)
  %finest = fmul double %ts, @@shortest@@
  %floor = fadd double %finest, 0x0010000000000000
  %left1 = fsub double %stop, %t
  %left = fsub double %left1, %tl
  %tiny = fcmp ole double %h, %floor
  %short = fcmp olt double %h, %left
  %stuck = and i1 %tiny, %short
  br i1 %stuck, label %return, label %approach
; Before a critical point: halve the distance until it is at the resolution of the numbers, then step over the point. If even
; extremely short steps are not confirmed, rounding may be the cause.
approach:
  %pace = load double, ptr %pacea, align 8
  %lastpass = load double, ptr %lasta, align 8
  %passes = load double, ptr %timesa, align 8
  %ulp = fmul double %ts, @@resolved@@
  br i1 %nogap, label %free, label %near
near:
  %half = fmul double %gap, 0.5
  %grain = select i1 %doubt, double @@doubt@@, double @@grain@@
  %least = call double @llvm.minnum.f64(double %h, double %pace)
  %measured = select i1 %doubt, double %least, double %pace
  %fine = fmul double %measured, %grain
  %resolved = fadd double %ulp, %fine
  %isfar1 = fcmp ogt double %half, %resolved
  %seen = fcmp ogt double %h, %resolved
  %apart0 = and i1 %isfar1, %seen
  %notfar = xor i1 %far, true
  %apart = and i1 %apart0, %notfar
  %before = call double @llvm.minnum.f64(double %h, double %half)
  br i1 %apart, label %bounded, label %between
between:
  %doubtful = and i1 %doubt, %notfar
  br i1 %doubtful, label %noisy, label %pass
noisy:
  br i1 %lax_still, label %return, label %free
; Passed many times while t hardly changes: the motion sticks at this point.
pass:
  %since = fsub double %t, %lastpass
  %no_time = fmul double %ts, @@no_time@@
  %atonce = fcmp ole double %since, %no_time
  %passes1 = fadd double %passes, 1.0
  %passes2 = select i1 %atonce, double %passes1, double 0.0
  %stays = fcmp oge double %passes2, @@passes@@
  br i1 %stays, label %return, label %straight
straight:
  call void @straighten(ptr %work)
  %twice_resolved = fmul double %resolved, 2.0
  %short_gap = call double @llvm.minnum.f64(double %gap, double %twice_resolved)
  %across = select i1 %far, double %gap, double %short_gap
  br label %bounded
; The pace shrinks no faster than steps do in front of a singularity; growing steps are short only because of what is behind.
free:
  %lax_free = phi i1 [ %lax_still, %approach ], [ true, %noisy ]
  %quarter_more = fmul double %hp, 1.25
  %grows = fcmp ogt double %h, %quarter_more
  %lagging = fmul double %pace, @@lag@@
  %kept = select i1 %grows, double %pace, double %lagging
  %pace_free = call double @llvm.maxnum.f64(double %h, double %kept)
  br label %bounded
bounded:
  %hl = phi double [ %h, %free ], [ %before, %near ], [ %across, %straight ]
  %over = phi i1 [ false, %free ], [ false, %near ], [ true, %straight ]
  %pace_next = phi double [ %pace_free, %free ], [ %pace, %near ], [ %pace, %straight ]
  %last_next = phi double [ %lastpass, %free ], [ %lastpass, %near ], [ %t, %straight ]
  %passes_next = phi double [ %passes, %free ], [ %passes, %near ], [ %passes2, %straight ]
  %lax_now = phi i1 [ %lax_free, %free ], [ %lax_still, %near ], [ %lax_still, %straight ]
  %isfree = phi i1 [ true, %free ], [ false, %near ], [ true, %straight ]
  %gap_rest = fsub double %gap, %hl
  %gap_next = select i1 %isfree, double 0.0, double %gap_rest
  br label %sampling
sampling:
  %at = phi i64 [ %index, %bounded ], [ %atn, %dense ]
  %sa = getelementptr inbounds double, ptr %times, i64 %at
  %s = load double, ptr %sa, align 8
  %away = call %pair @since(double %s, double %t, double %tl)
  %dt = extractvalue %pair %away, 0
  %dtl = extractvalue %pair %away, 1
  %within = fcmp ole double %dt, %hl
  br i1 %within, label %dense, label %sampledall
dense:
  %place = getelementptr inbounds double, ptr %out, i64 %at
  %dts = fmul double %dt, %inverse
  %dtls = fmul double %dtl, %inverse
  call void @sample(ptr %state, ptr %work, double %dts, double %dtls, ptr %place, i64 %stride, i64 %beyond)
  %atn = add i64 %at, 1
  br label %sampling
sampledall:
  %final = fcmp ole double %left, %hl
  %usedup = icmp uge i64 %at, %count
  %islast = icmp ne i64 %last, 0
  %ending0 = and i1 %usedup, %islast
  %ending = and i1 %ending0, %final
  %nomore = xor i1 %islast, true
  %leave = and i1 %usedup, %nomore
  %rest = call %pair @since(double %stop, double %t, double %tl)
  %resth = extractvalue %pair %rest, 0
  %restl = extractvalue %pair %rest, 1
  %hs = select i1 %ending, double %resth, double %hl
  %hsl = select i1 %ending, double %restl, double 0.0
  call void @copy(ptr %state, ptr %trial)
  %hss = fmul double %hs, %inverse
  %hsls = fmul double %hsl, %inverse
  call void @update(ptr %state, ptr %work, double %hss, double %hsls)
  %clock = call %pair @pair_add(double %t, double %tl, double %hs, double %hsl)
  %tnew = extractvalue %pair %clock, 0
  %tlnew = extractvalue %pair %clock, 1
  store double %tnew, ptr %tpa, align 8
  store double %tlnew, ptr %tla, align 8
  store double %h, ptr %hpa, align 8
  store double %gap_next, ptr %gapa, align 8
  store double %pace_next, ptr %pacea, align 8
  store double %last_next, ptr %lasta, align 8
  store double %passes_next, ptr %timesa, align 8
  %per_pace = fdiv double 1.0, %pace_next
  %noise = fmul double %ulp, %per_pace
  %usually_close = fadd double %noise, @@almost@@
  %close = select i1 %over, double 0.0, double %usually_close
  %slow = fmul double %per_pace, @@rounding@@
  %fast = fdiv double @@resolution@@, %hs
  %speed0 = fadd double %slow, %fast
  %passing = fdiv double @@almost@@, %hs
  %speed = select i1 %over, double %passing, double %speed0
  %uneven0 = fmul double %slow, %per_pace
  %uneven = select i1 %over, double 0.0, double %uneven0
  call void @expect(ptr %trial, ptr %state, ptr %work, double %hss, double %hsls, double %inverse, double %close, double %speed, double %uneven, ptr %expected)
  br label %advanced
advanced:
  %taken1 = add i64 %taken, 1
  %pending_leave = select i1 %leave, i64 @@samples@@, i64 -1
  %pending1 = select i1 %ending, i64 @@end@@, i64 %pending_leave
  br label %step
return:
  %code = phi i64 [ %pending, %confirmed ], [ @@samples@@, %many ], [ @@pause@@, %checked ], [ @@singular@@, %expanded ], [ @@not_finite@@, %wall ], [ %cause, %inside ], [ @@not_finite@@, %narrow ], [ @@underflow@@, %long ], [ @@underflow@@, %noisy ], [ @@underflow@@, %pass ]
  %used = phi i64 [ %index, %confirmed ], [ %index, %many ], [ %index, %checked ], [ %index, %expanded ], [ %from, %wall ], [ %from, %inside ], [ %index, %narrow ], [ %index, %long ], [ %index, %noisy ], [ %index, %pass ]
  %steps = phi i64 [ %taken, %confirmed ], [ %without, %many ], [ %taken, %checked ], [ %taken, %expanded ], [ %taken, %wall ], [ %less1, %inside ], [ %taken, %narrow ], [ %taken, %long ], [ %taken, %noisy ], [ %taken, %pass ]
  store i64 %used, ptr %info, align 8
  store i64 %steps, ptr %stepsa, align 8
  ret i64 %code
}
