; See definite.py. %a has %stride rows of %stride doubles, a multiple of 8, and behind them 8 doubles a row for the
; diagonal blocks.
define internal void @arrange_definite(ptr noalias %a, ptr noalias %reciprocal, i64 %stride) #0 {
entry:
  %size = mul i64 %stride, %stride
  %blocks = getelementptr inbounds double, ptr %a, i64 %size
  br label %row
row:
  %j = phi i64 [ 0, %entry ], [ %jn, %row_done ]
  %rp = getelementptr inbounds double, ptr %reciprocal, i64 %j
  %r = load double, ptr %rp, align 8
  %nr = fneg double %r
  %base = mul i64 %j, %stride
  %jp = getelementptr inbounds double, ptr %a, i64 %base
  %diagonal = getelementptr inbounds double, ptr %jp, i64 %j
  store double 0.0, ptr %diagonal, align 8
  %inside = and i64 %j, 7
  %from = and i64 %j, -8
  br label %column
column:
  %i = phi i64 [ %from, %row ], [ %in, %stored ]
  %ap = getelementptr inbounds double, ptr %jp, i64 %i
  %u = load double, ptr %ap, align 8
  %l = fmul double %u, %nr
  store double %l, ptr %ap, align 8
  %iblock = and i64 %i, -8
  %same = icmp eq i64 %iblock, %from
  br i1 %same, label %within, label %across
within:
  %di = mul i64 %i, 8
  %dplace = add i64 %di, %inside
  %dp = getelementptr inbounds double, ptr %blocks, i64 %dplace
  store double %l, ptr %dp, align 8
  br label %stored
across:
  %ti = mul i64 %i, %stride
  %tplace = add i64 %ti, %j
  %tp = getelementptr inbounds double, ptr %a, i64 %tplace
  store double %l, ptr %tp, align 8
  br label %stored
stored:
  %in = add i64 %i, 1
  %imore = icmp ult i64 %in, %stride
  br i1 %imore, label %column, label %row_done
row_done:
  %jn = add i64 %j, 1
  %jmore = icmp ult i64 %jn, %stride
  br i1 %jmore, label %row, label %done
done:
  ret void
}

define internal void @solve_definite(ptr noalias %a, ptr noalias %reciprocal, ptr noalias %b, i64 %n, i64 %stride) #0 {
entry:
  %size = mul i64 %stride, %stride
  %blocks = getelementptr inbounds double, ptr %a, i64 %size
  br label %forward
forward:
  %j = phi i64 [ 0, %entry ], [ %jn, %forward_done ]
  %rows = mul i64 %j, %stride
  %place = add i64 %rows, %j
  %jp = getelementptr inbounds double, ptr %a, i64 %place
  %bp = getelementptr inbounds double, ptr %b, i64 %j
  %r = load <8 x double>, ptr %bp, align 64
@@forward@@
  %rp = getelementptr inbounds double, ptr %reciprocal, i64 %j
  %inverse = load <8 x double>, ptr %rp, align 64
  %scaled = fmul <8 x double> %r.end, %inverse
  store <8 x double> %scaled, ptr %bp, align 64
  %jn = add i64 %j, 8
  %jmore = icmp ult i64 %jn, %stride
  br i1 %jmore, label %below, label %forward_done
below:
  %i = phi i64 [ %jn, %forward ], [ %in, %below ]
  %ip = getelementptr inbounds double, ptr %b, i64 %i
  %r.old = load <8 x double>, ptr %ip, align 64
  %r.column = sub i64 %i, %j
@@forward_trail@@
  store <8 x double> %r.sum, ptr %ip, align 64
  %in = add i64 %i, 8
  %imore = icmp ult i64 %in, %stride
  br i1 %imore, label %below, label %forward_done
forward_done:
  br i1 %jmore, label %forward, label %backward
backward:
  %m1 = phi i64 [ %stride, %forward_done ], [ %m, %backward_done ]
  %m = sub i64 %m1, 8
  %mrows = mul i64 %m, %stride
  %mp = getelementptr inbounds double, ptr %a, i64 %mrows
  %drows = mul i64 %m, 8
  %dp = getelementptr inbounds double, ptr %blocks, i64 %drows
  %xp = getelementptr inbounds double, ptr %b, i64 %m
  %x = load <8 x double>, ptr %xp, align 64
@@backward@@
  store <8 x double> %x.end, ptr %xp, align 64
  %again = icmp ugt i64 %m, 0
  br i1 %again, label %above, label %done
above:
  %k = phi i64 [ 0, %backward ], [ %kn, %above ]
  %kp = getelementptr inbounds double, ptr %b, i64 %k
  %x.old = load <8 x double>, ptr %kp, align 64
  %x.column = add i64 %k, 0
@@backward_trail@@
  store <8 x double> %x.sum, ptr %kp, align 64
  %kn = add i64 %k, 8
  %kmore = icmp ult i64 %kn, %m
  br i1 %kmore, label %above, label %backward_done
backward_done:
  br label %backward
done:
  ret void
}
